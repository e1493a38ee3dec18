// node scripts_test.mjs: the parts of the live page that need no browser.
import assert from 'node:assert/strict';
import {decode_cloud, decode_grid} from '../../web/src/live/cdr.js';
import {worst_links} from '../../web/src/live/links.js';
import {ago, bytes, clock, metres, percent} from '../../web/src/live/format.js';
import {History} from '../../web/src/live/history.js';
import {trail_at} from '../../web/src/live/trails.js';

/** Writes CDR by hand, so that the reader is not compared with itself. */
class Writer {
  constructor() { this.bytes = [0, 1, 0, 0]; }

  align(n) { while ((this.bytes.length - 4) % n) this.bytes.push(0); }

  put(n, set, value) {
    this.align(n);
    const view = new DataView(new ArrayBuffer(n));
    view[set](0, value, true);
    this.bytes.push(...new Uint8Array(view.buffer));
    return this;
  }

  u8(v) { return this.put(1, 'setUint8', v); }
  u32(v) { return this.put(4, 'setUint32', v); }
  f32(v) { return this.put(4, 'setFloat32', v); }
  f64(v) { return this.put(8, 'setFloat64', v); }

  text(v) {
    this.u32(v.length + 1);
    this.bytes.push(...[...v].map((c) => c.charCodeAt(0)), 0);
    return this;
  }

  view() { return new DataView(Uint8Array.from(this.bytes).buffer); }
}

function cloud_of(points, extra = []) {
  const out = new Writer().u32(12).u32(500000000).text('map').u32(1).u32(points.length).u32(3 + extra.length);
  ['x', 'y', 'z'].forEach((name, i) => out.text(name).u32(4 * i).u8(7).u32(1));
  extra.forEach((name, i) => out.text(name).u32(12 + 4 * i).u8(6).u32(1));
  const step = 12 + 4 * extra.length;
  out.u8(0).u32(step).u32(step * points.length).u32(step * points.length);
  const floats = new DataView(new ArrayBuffer(step * points.length));
  points.forEach((p, i) => p.forEach((value, k) => (k < 3 ? floats.setFloat32(i * step + 4 * k, value, true) : floats.setUint32(i * step + 4 * k, value, true))));
  out.bytes.push(...new Uint8Array(floats.buffer), 1);
  return out;
}

const tests = {
  a_cloud_is_read_with_its_stamp_and_keyframes() {
    const cloud = decode_cloud(cloud_of([[1, 2, 3, 7], [4, 5, 6, 8]], ['keyframe']).view(), 100);
    assert.equal(cloud.stamp_s, 12.5);
    assert.equal(cloud.frame, 'map');
    assert.deepEqual([...cloud.positions], [1, 2, 3, 4, 5, 6]);
    assert.deepEqual([...cloud.keyframe], [7, 8]);
    assert.equal(cloud.age_s, null);
  },
  a_cloud_is_cut_at_the_most_points_shown() {
    assert.equal(decode_cloud(cloud_of([[1, 2, 3], [4, 5, 6]]).view(), 1).count, 1);
  },
  each_cut_of_a_cloud_is_refused() {
    const whole = cloud_of([[1, 2, 3], [4, 5, 6]]).bytes;
    for (let n = 0; n < whole.length - 1; ++n) {
      assert.throws(() => decode_cloud(new DataView(Uint8Array.from(whole.slice(0, n)).buffer), 100), RangeError);
    }
  },
  a_length_that_lies_is_refused() {
    const bytes = cloud_of([[1, 2, 3]]).bytes;
    for (let at = 4; at + 4 <= bytes.length; at += 4) {
      const damaged = [...bytes];
      damaged.splice(at, 4, 0xff, 0xff, 0xff, 0x7f);
      try { assert.ok(decode_cloud(new DataView(Uint8Array.from(damaged).buffer), 100).count <= 1); } catch (error) { assert.ok(error instanceof RangeError); }
    }
  },
  a_grid_is_read() {
    const out = new Writer().u32(1).u32(0).text('map').u32(1).u32(0).f32(0.5).u32(2).u32(1);
    for (const v of [-3, 4, 0, 0, 0, Math.SQRT1_2, Math.SQRT1_2]) out.f64(v);
    out.u32(2).u8(100).u8(255);
    const grid = decode_grid(out.view());
    assert.deepEqual([grid.width, grid.height, grid.resolution_m, grid.x_m, grid.y_m], [2, 1, 0.5, -3, 4]);
    assert.ok(Math.abs(grid.yaw_rad - Math.PI / 2) < 1e-12);
    assert.deepEqual([...grid.cells], [100, 255]);
  },
  a_table_that_moves_a_pose_by_more_than_a_decimetre_is_announced_once() {
    const history = new History();
    const state = (t_s, revision, moved_max_m) => ({t_s, table: {term: 1, revision, moved_max_m}});
    assert.equal(history.add(state(0, 1, 0.1)).length, 0);
    assert.match(history.add(state(1, 2, 0.34))[0].text, /moved the map by up to 0.34 m/);
    assert.equal(history.add(state(2, 2, 0.34)).length, 0);
    assert.equal(history.add(state(3, 3, 0.2)).length, 1);
  },
  a_move_whose_frame_was_lost_is_still_listed_at_its_time_and_once() {
    const history = new History();
    const moves = [{term: 1, revision: 7, moved_max_m: 0.5, t_s: 3}];
    history.add({t_s: 0});
    assert.deepEqual(history.add({t_s: 9, table_moves: moves}).map((e) => e.t_s), [3]);
    assert.equal(history.add({t_s: 10, table_moves: moves, table: moves[0]}).length, 0);
  },
  a_lost_anchor_and_its_return_are_events() {
    const history = new History();
    history.add({t_s: 0, anchor: {vehicle: 'v1'}});
    assert.equal(history.add({t_s: 1, anchor: {vehicle: 'v1', lost: {vehicle: 'v1', message: 'v1 is gone.'}}})[0].text, 'Anchor v1 is lost.');
    assert.equal(history.add({t_s: 2, anchor: {vehicle: 'v2'}}).length, 2);
  },
  a_day_of_states_is_thinned_and_the_last_ten_minutes_are_whole() {
    const history = new History();
    for (let t = 0; t < 86400; ++t) history.add({t_s: t});
    assert.ok(history.states.length <= 4001, `${history.states.length}`);
    assert.equal(history.states.filter((s) => s.t_s > 86400 - 590).length, 589);
    assert.equal(history.first_s, 0);
    assert.equal(history.at(86399).t_s, 86399);
    for (const t of [0, 100, 40000.5, 86000]) assert.ok(Math.abs(history.at(t).t_s - t) < 60);
  },
  a_clock_that_starts_again_starts_a_new_history() {
    const history = new History();
    history.add({t_s: 100});
    history.add({t_s: 3});
    assert.deepEqual(history.states.map((s) => s.t_s), [3]);
  },
  a_trail_is_that_of_the_newest_table_and_of_what_was_seen_since() {
    const history = new History();
    for (let t = 0; t <= 5; ++t) history.add({t_s: t, vehicles: [{name: 'v1', position_m: [t, 1, 0]}]});
    const paths = [{vehicle: 'v1', t_s: [0, 1, 2], position_m: [[0, 0, 0], [1, 0, 0], [2, 0, 0]], degenerate: [0, 1, 0]}];
    assert.deepEqual(trail_at('v1', 5, paths, history).points.map((p) => p.join()), ['0,0,0', '1,0,0', '2,0,0', '3,1,0', '4,1,0', '5,1,0']);
    assert.deepEqual(trail_at('v1', 1.5, paths, history), {points: [[0, 0, 0], [1, 0, 0]], degenerate: [0, 1]});
    assert.equal(trail_at('v1', 3, null, history).points.length, 4);
  },
  both_directions_of_a_link_are_one_and_the_worse_counts() {
    const [link] = worst_links([{from: 'b', to: 'a', connected: true, loss: 0.1, rate_Bps: 5}, {from: 'a', to: 'b', connected: false, loss: 0.3}]);
    assert.deepEqual([link.connected, link.loss, link.rate_Bps], [false, 0.3, 5]);
  },
  what_is_not_known_is_a_dash() {
    for (const f of [metres, percent, bytes, ago]) assert.equal(f(undefined), '–');
    assert.equal(bytes(41.2e9), '41 GB');
    assert.equal(percent(0.0123), '1.2 %');
    assert.equal(clock(3723), '1:02:03');
  },
};

for (const [name, run] of Object.entries(tests)) {
  run();
  console.log(`ok: ${name}`);
}
