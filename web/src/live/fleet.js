// One state of the fleet in the 3-D view.
import {Color} from 'three';
import {DEGENERATE, FRONTIER, link_colour, RANGE, RANGE_UNUSED, vehicle_colour} from './colours.js';
import {metres, percent, rate} from './format.js';
import {worst_links} from './links.js';
import {Lines, make_beacon, make_ellipse, make_mark, make_vehicle} from './shapes.js';

const OLD_S = 3;
const LIFT_M = 0.12;  // lines lie above the floor's points
const rgb = (hex) => new Color(hex);
const lifted = ([x, y, z], by = LIFT_M) => [x, y, (z ?? 0) + by];

export class Fleet {
  constructor(view, labels) {
    this.view = view;
    this.labels = labels;
    this.trails = new Lines(2.6, {depthTest: false});
    this.stretches = new Lines(9, {opacity: 0.35, depthTest: false});
    this.links = new Lines(2, {opacity: 0.9});
    this.cut = new Lines(2, {opacity: 0.9, dashed: true, dashSize: 0.7, gapSize: 0.6});
    this.ranges = new Lines(1.4, {opacity: 0.8, depthTest: false});
    this.unused = new Lines(1.4, {opacity: 0.8, dashed: true, dashSize: 0.35, gapSize: 0.5});
    this.ways = new Lines(1.8, {opacity: 0.75, dashed: true, dashSize: 0.8, gapSize: 0.5});
    for (const lines of [this.stretches, this.trails, this.links, this.cut, this.ranges, this.unused, this.ways]) view.scene.add(lines.object);
    this.trails.object.renderOrder = 5;
    this.vehicles = new Map();
    this.marks = [];
    this.beacon = make_beacon();
    this.lost = make_beacon();
    for (const material of [this.lost.userData.beam.material, this.lost.userData.ring.material]) material.color.set('#e5484d');
    view.scene.add(this.beacon, this.lost);
    this.show = {links: true, ranges: true, goals: true, trails: true};
  }

  /** From afar the shapes keep a size that can be seen. */
  rescale() {
    const grow = (object, size_m, pixels, least = 1) => {
      const distance_m = this.view.camera.position.distanceTo(object.position);
      const pixels_per_m = this.view.scale / this.view.renderer.getPixelRatio() / distance_m;
      object.scale.setScalar(Math.max(least, pixels / (size_m * pixels_per_m)));
    };
    for (const {shape} of this.vehicles.values()) grow(shape, 1.5, 24);
    for (const beacon of [this.beacon, this.lost]) grow(beacon, 2.9, 36);
    for (const mark of this.marks) grow(mark, 0.6, 9, mark.userData.size);
  }

  /** @param trail_of (name) => {points, degenerate} up to the state's time */
  set(state, trail_of) {
    this.names = (state.vehicles ?? []).map((v) => v.name);
    this.places = new Map((state.vehicles ?? []).filter((v) => v.position_m).map((v) => [v.name, v.position_m]));
    const labels = [];
    this.set_vehicles(state, labels);
    this.set_anchor(state, labels);
    this.set_trails(state, trail_of);
    this.set_links(state, labels);
    this.set_ranges(state, labels);
    this.set_goals(state, labels);
    this.labels.set(labels);
  }

  colour_of(name) {
    return vehicle_colour(Math.max(this.names.indexOf(name), 0));
  }

  set_vehicles(state, labels) {
    for (const {shape, ellipse} of this.vehicles.values()) shape.visible = ellipse.visible = false;
    for (const v of state.vehicles ?? []) {
      if (!v.position_m) continue;
      const {shape, ellipse} = this.vehicle(v.name);
      const old = v.age_s > OLD_S;
      shape.visible = true;
      shape.position.set(...v.position_m);
      shape.rotation.z = v.yaw_rad ?? 0;
      shape.userData.body.material.opacity = old ? 0.35 : 1;
      shape.userData.dot.material.color.set(v.degenerate ? DEGENERATE : '#ffffff');
      if (v.ellipse) {
        ellipse.visible = true;
        ellipse.position.set(v.position_m[0], v.position_m[1], v.position_m[2] + 0.03);
        ellipse.rotation.z = v.ellipse.angle_rad ?? 0;
        ellipse.scale.set(Math.max(2 * v.ellipse.major_m, 0.05), Math.max(2 * v.ellipse.minor_m, 0.05), 1);
      }
      if (state.anchor?.lost?.vehicle === v.name) continue;  // it has a label of its own
      labels.push({
        key: `v ${v.name}`, place: lifted(v.position_m, 1.1), kind: old ? 'vehicle old' : 'vehicle', colour: this.colour_of(v.name),
        text: v.name, note: old ? `heard ${v.age_s.toFixed(0)} s ago` : v.degenerate ? 'degenerate' : v.mode ?? '',
      });
    }
  }

  vehicle(name) {
    if (!this.vehicles.has(name)) {
      const colour = this.colour_of(name);
      const made = {shape: make_vehicle(colour), ellipse: make_ellipse(colour)};
      this.view.scene.add(made.shape, made.ellipse);
      this.vehicles.set(name, made);
    }
    return this.vehicles.get(name);
  }

  set_anchor(state, labels) {
    const place = this.places.get(state.anchor?.vehicle);
    const lost = state.anchor?.lost;
    this.beacon.visible = Boolean(place) && !lost;
    if (place) this.beacon.position.set(...place);
    const last = lost?.position_m ?? (lost && this.places.get(lost.vehicle));
    this.lost.visible = Boolean(last);
    if (!last) return;
    this.lost.position.set(...last);
    labels.push({key: 'lost', place: lifted(last, 3.2), kind: 'lost', text: `${lost.vehicle} last seen`, colour: '#e5484d'});
  }

  set_trails(state, trail_of) {
    const segments = [];
    for (const name of this.show.trails ? this.names : []) {
      const {points, degenerate} = trail_of(name);
      const own = rgb(this.colour_of(name));
      const open = rgb(DEGENERATE);
      for (let i = 1; i < points.length; ++i) {
        segments.push([lifted(points[i - 1]), lifted(points[i]), degenerate?.[i] ? open : own]);
      }
    }
    this.trails.set(segments);
    const wide = [];
    for (const s of state.degenerate_stretches ?? []) {
      for (let i = 1; i < s.path_m.length; ++i) wide.push([lifted(s.path_m[i - 1], 0.06), lifted(s.path_m[i], 0.06), rgb(DEGENERATE)]);
    }
    this.stretches.set(wide);
  }

  /** One arc per pair; the worse direction gives its colour. */
  set_links(state, labels) {
    const [good, cut] = [[], []];
    for (const link of this.show.links ? worst_links(state.links ?? []) : []) {
      const [a, b] = [this.places.get(link.from), this.places.get(link.to)];
      if (!a || !b) continue;
      const colour = rgb(link_colour(link));
      const arc = arc_between(a, b);
      const segments = link.connected ? good : cut;
      for (let i = 1; i < arc.length; ++i) segments.push([arc[i - 1], arc[i], colour]);
      const note = link.connected ? `${percent(link.loss)} loss, ${rate(link.rate_Bps)}` : 'no link';
      labels.push({key: `l ${link.from} ${link.to}`, place: arc[arc.length >> 1], kind: 'link', note, colour: link_colour(link)});
    }
    this.links.set(good);
    this.cut.set(cut);
  }

  set_ranges(state, labels) {
    const [used, unused] = [[], []];
    for (const range of this.show.ranges ? state.ranges ?? [] : []) {
      const [a, b] = [this.places.get(range.from), this.places.get(range.to)];
      if (!a || !b || range.age_s > OLD_S) continue;
      (range.used ? used : unused).push([lifted(a, 0.4), lifted(b, 0.4), rgb(range.used ? RANGE : RANGE_UNUSED)]);
      const middle = a.map((value, i) => 0.62 * value + 0.38 * b[i]);
      labels.push({key: `r ${range.from} ${range.to}`, place: lifted(middle, 0.4), kind: range.used ? 'range' : 'range unused', note: metres(range.range_m)});
    }
    this.ranges.set(used);
    this.unused.set(unused);
  }

  set_goals(state, labels) {
    for (const mark of this.marks) this.view.scene.remove(mark);
    this.marks = [];
    const ways = [];
    const add = (p, colour, kind, size = 1) => {
      const mark = make_mark(colour, kind);
      mark.position.set(...lifted(p, kind === 'goal' ? 0.4 : 0.3));
      mark.userData.size = size;
      this.view.scene.add(mark);
      this.marks.push(mark);
    };
    if (this.show.goals) {
      for (const f of state.frontiers ?? []) add(f.position_m, FRONTIER, 'frontier', Math.min(Math.max((f.size_m ?? 1) / 2, 0.7), 2));
      for (const goal of state.goals ?? []) {
        add(goal.position_m, this.colour_of(goal.vehicle), 'goal');
        labels.push({key: `g ${goal.vehicle}`, place: lifted(goal.position_m, 1.6), kind: 'goal', note: `goal of ${goal.vehicle}`, colour: this.colour_of(goal.vehicle)});
        const start = this.places.get(goal.vehicle);
        const path = goal.path_m ?? (start ? [start, goal.position_m] : []);
        for (let i = 1; i < path.length; ++i) ways.push([lifted(path[i - 1]), lifted(path[i]), rgb(this.colour_of(goal.vehicle))]);
      }
    }
    this.ways.set(ways);
  }
}

function arc_between(a, b) {
  const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
  const height = Math.min(1 + 0.12 * length, 5);
  const out = [];
  for (let i = 0; i <= 16; ++i) {
    const u = i / 16;
    out.push([a[0] + u * (b[0] - a[0]), a[1] + u * (b[1] - a[1]), (1 - u) * a[2] + u * b[2] + 0.6 + 4 * height * u * (1 - u)]);
  }
  return out;
}
