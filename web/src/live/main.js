// The live page of a vehicle, and the same page for finished results.
import {decode_cloud, decode_grid} from './cdr.js';
import {connect} from './connection.js';
import {by_id} from './dom.js';
import {Fleet} from './fleet.js';
import {make_plan} from './plan.js';
import {History} from './history.js';
import {Labels} from './labels.js';
import {announce, show_events, show_state} from './panel.js';
import {POINTS_MAX, PointStore} from './points.js';
import {make_grid, View} from './scene.js';
import {Timeline} from './timeline.js';
import {trail_at} from './trails.js';

const NEWS_S = 60;  // older moves of the map are listed, not announced

class Page {
  constructor() {
    this.history = new History();
    this.paths = null;
    this.names = [];
    this.timeline = new Timeline(this.history, () => this.show());
    this.start_view();
    this.start_buttons();
    this.set_connected(false);
    connect({
      open: () => this.set_connected(true),
      closed: () => this.set_connected(false),
      message: (topic, t_s, view) => this.take(topic, t_s, view),
    });
  }

  start_view() {
    const holder = by_id('view');
    try {
      this.view = new View(holder);
    } catch {
      by_id('no-webgl').hidden = false;
      holder.dataset.state = 'no webgl';
      return;
    }
    this.store = new PointStore();
    this.grid = make_grid();
    this.view.scene.add(this.grid, this.store.points);
    this.fleet = new Fleet(this.view, new Labels(by_id('labels'), this.view));
    this.view.before = [() => {
      this.store.points.material.uniforms.scale.value = this.view.scale;
      this.fleet.rescale();
    }];
    this.view.on_let_go = () => by_id('fit').setAttribute('aria-pressed', 'false');
  }

  start_buttons() {
    by_id('fit').addEventListener('click', () => {
      if (!this.view) return;
      this.view.follows = true;
      by_id('fit').setAttribute('aria-pressed', 'true');
      this.fit();
      this.view.draw();
    });
    by_id('colour').addEventListener('change', () => {
      if (this.store) this.store.points.material.uniforms.by.value = by_id('colour').value === 'vehicle' ? 1 : 0;
      this.view?.draw();
    });
    for (const box of document.querySelectorAll('[data-show]')) {
      box.addEventListener('change', () => this.set_shown(box.dataset.show, box.checked));
    }
  }

  set_shown(what, on) {
    if (!this.fleet) return;
    if (what === 'plan') {
      if (this.plan) this.plan.visible = on;
    } else if (what === 'roof') this.set_cut();
    else this.fleet.show[what] = on;
    this.show();
  }

  set_connected(on) {
    this.connected = on;
    this.show_chip();
  }

  show_chip() {
    const chip = by_id('chip');
    const [text, kind] = !this.timeline.live ? ['past', 'past']
      : this.timeline.finished ? ['finished run', 'past']
        : this.connected ? ['live', 'good'] : ['no connection', 'bad'];
    chip.textContent = text;
    chip.className = `state ${kind}`;
    by_id('live').textContent = this.timeline.finished ? 'End' : 'Live';
  }

  take(topic, t_s, view) {
    try {
      if (topic.startsWith('/rali/')) this.take_json(topic, JSON.parse(new TextDecoder().decode(view)));
      else if (topic === '/map') this.take_plan(decode_grid(view));
      else this.take_cloud(topic, decode_cloud(view, POINTS_MAX));
    } catch (error) {
      console.warn(`a message of ${topic} was dropped: ${error.message}`);
    }
  }

  take_json(topic, message) {
    if (topic === '/rali/state') this.take_state(message);
    else if (topic === '/rali/paths') this.paths = message.paths;
    else this.take_history(message.states);
  }

  take_state(state) {
    if (!Number.isFinite(state.t_s)) return;
    if (this.history.states.at(-1)?.t_s === state.t_s) return;
    this.store?.set_start(state.t_s);
    const first = this.history.states.length === 0;
    const events = this.history.add(state);
    this.names = (state.vehicles ?? []).map((v) => v.name);
    // What the first state reports may be old.
    for (const event of first || this.timeline.finished ? [] : events) {
      if (state.t_s - event.t_s < NEWS_S) announce(event);
    }
    this.timeline.marks(this.history.events);
    show_events(this.history.events, this.history.first_s, (event) => this.timeline.go(event.t_s));
    this.timeline.refresh();
    if (this.timeline.live) this.show();
  }

  take_history(states) {
    const last = this.history.states.at(-1);
    this.history.clear();
    this.timeline.finished = true;
    if (this.store) this.store.start_s = states[0]?.t_s;
    for (const state of states) this.history.add(state);
    if (last && last.t_s > this.history.last_s) this.history.add(last);
    this.timeline.marks(this.history.events);
    show_events(this.history.events, this.history.first_s, (event) => this.timeline.go(event.t_s));
    this.timeline.go(null);
  }

  take_cloud(topic, cloud) {
    if (!this.store) return;
    const vehicle = Math.max(this.names.indexOf(topic.split('/')[1]), 0);
    this.store.add(cloud, vehicle, topic === '/map_cloud');
    this.set_cut();
    this.fit();
    this.view.holder.dataset.state = `${this.store.count} points`;
    this.view.draw();
  }

  /** Without the roof one sees into rooms and tunnels. */
  set_cut() {
    const {uniforms} = this.store.points.material;
    const [low, high] = [uniforms.low_m.value, uniforms.high_m.value];
    uniforms.cut_m.value = by_id('roof').checked || high - low > 12 ? 1e9 : low + 0.72 * (high - low);
    this.grid.position.z = low - 0.15;
  }

  take_plan(grid) {
    if (!this.view) return;
    if (this.plan) this.view.scene.remove(this.plan);
    this.plan = make_plan(grid);
    this.plan.position.z = this.store.count ? this.store.points.material.uniforms.low_m.value - 0.1 : -0.1;
    this.plan.visible = document.querySelector('[data-show=plan]').checked;
    this.view.scene.add(this.plan);
    this.view.draw();
  }

  fit() {
    if (!this.view?.follows) return;
    const places = this.store.sample(3000);
    const {vehicles = [], goals = []} = this.history.states.at(-1) ?? {};
    for (const {position_m: p} of [...vehicles, ...goals]) {
      if (p) places.push(p[0] - 3, p[1] - 3, p[2], p[0] + 3, p[1] + 3, p[2] + 1);
    }
    if (places.length) this.view.fit(places);
  }

  show() {
    this.show_chip();
    const state = this.timeline.live ? this.history.states.at(-1) : this.history.at(this.timeline.t_s);
    if (!state) return;
    by_id('empty').hidden = true;
    show_state(state, (v) => { if (v.position_m) this.view?.look_at(v.position_m); });
    document.title = `${state.anchor?.lost ? 'anchor lost – ' : ''}${state.vehicle ?? ''} – RaLI`;
    if (!this.view) return;
    const t_s = this.timeline.t_s ?? state.t_s;
    // Live clouds may carry a stamp slightly newer than the state; nothing of them is to be hidden.
    this.store.points.material.uniforms.now_s.value = this.timeline.live ? Math.max(t_s - this.store.start_s, 0) + 5 : t_s - this.store.start_s;
    this.fleet.set(state, (name) => trail_at(name, t_s, this.paths, this.history));
    if (this.store.count === 0) this.fit();
    this.view.draw();
    document.body.dataset.shown = String(this.history.states.length);
  }
}

by_id('no-bundle').remove();
window.rali = new Page();
