// The slider below the map: live, back, and playing what was.
import {by_id, el} from './dom.js';
import {clock} from './format.js';

const FRAME_MS = 50;

export class Timeline {
  /** @param on_time called with t_s, or null for the newest */
  constructor(history, on_time) {
    this.history = history;
    this.on_time = on_time;
    this.t_s = null;  // null: live
    this.slider = by_id('time');
    this.slider.addEventListener('input', () => this.go(this.history.first_s + this.slider.valueAsNumber));
    by_id('live').addEventListener('click', () => this.go(null));
    by_id('play').addEventListener('click', () => this.toggle());
  }

  get live() { return this.t_s === null; }

  go(t_s) {
    const end = this.history.last_s;
    this.t_s = t_s === null || t_s >= end - 0.01 ? null : Math.max(t_s, this.history.first_s);
    if (this.live) this.stop();
    this.on_time(this.t_s);
    this.refresh();
  }

  toggle() {
    if (this.timer) return this.stop();
    if (this.live) this.go(this.history.first_s);
    // The whole of a finished run takes 30 s, what runs now is played at ten times its speed.
    const length_s = this.history.last_s - this.history.first_s;
    this.step_s = (FRAME_MS / 1000) * Math.max(this.finished ? length_s / 30 : 10, 0.5);
    this.timer = setInterval(() => this.go((this.t_s ?? this.history.last_s) + this.step_s), FRAME_MS);
    by_id('play').textContent = '❚❚';
    by_id('play').title = 'pause';
  }

  stop() {
    clearInterval(this.timer);
    this.timer = 0;
    by_id('play').textContent = '▶';
    by_id('play').title = 'play';
  }

  refresh() {
    const {first_s, last_s} = this.history;
    const length_s = Math.max(last_s - first_s, 0.001);
    const now_s = this.t_s ?? last_s;
    this.slider.max = length_s.toFixed(2);
    if (document.activeElement !== this.slider || this.live || this.timer) this.slider.value = now_s - first_s;
    this.slider.style.setProperty('--done', `${(100 * (now_s - first_s)) / length_s}%`);
    by_id('now').textContent = clock(now_s - first_s);
    by_id('end').textContent = clock(length_s);
    by_id('live').setAttribute('aria-pressed', String(this.live));
  }

  marks(events) {
    const {first_s, last_s} = this.history;
    const length_s = Math.max(last_s - first_s, 0.001);
    by_id('marks').replaceChildren(...events.filter((e) => e.t_s >= first_s).map((event) => {
      const mark = el('i', event.level);
      mark.style.left = `${(100 * (event.t_s - first_s)) / length_s}%`;
      return mark;
    }));
  }
}
