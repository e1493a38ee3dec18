// The states that the page has seen, so that the timeline can go back; and what happened between them.

const FINE_S = 600;      // all states of so long ago are kept,
const COARSE_S = 5;      // of older ones about one per so many seconds,
const STATES_MAX = 4000; // or fewer: a state of a long mission has some 10 kB.
const MOVED_M = 0.1;     // a table that moves a pose by more is announced
const EVENTS_MAX = 400;

export class History {
  constructor() {
    this.clear();
  }

  get first_s() { return this.states[0]?.t_s ?? 0; }
  get last_s() { return this.states.at(-1)?.t_s ?? 0; }

  /** @return the events that this state brings */
  add(state) {
    // A restarted host starts its clock again.
    if (state.t_s < this.last_s - 1) this.clear();
    const events = this.events_of(this.states.at(-1), state);
    this.states.push(state);
    this.events.push(...events);
    if (this.events.length > EVENTS_MAX) this.events.splice(0, this.events.length - EVENTS_MAX);
    this.thin();
    return events;
  }

  clear() {
    this.states = [];
    this.events = [];
    this.tables = new Set();
    this.coarse_s = COARSE_S;
    this.thinned = 0;  // up to here
  }

  /** Old states that are nearer to each other than `coarse_s` go; of too many all get sparser. */
  thin() {
    const limit = this.last_s - FINE_S;
    while (this.thinned + 2 < this.states.length && this.states[this.thinned + 2].t_s < limit) {
      if (this.states[this.thinned + 2].t_s - this.states[this.thinned].t_s < this.coarse_s) this.states.splice(this.thinned + 1, 1);
      else ++this.thinned;
    }
    if (this.states.length <= STATES_MAX) return;
    this.coarse_s *= 2;
    this.thinned = 0;
  }

  /** Index of the newest state not after t_s. */
  index_at(t_s) {
    let [low, high] = [0, this.states.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.states[middle].t_s <= t_s) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  at(t_s) {
    return this.states[this.index_at(t_s)];
  }

  events_of(before, now) {
    const out = [];
    const event = (level, text) => out.push({t_s: now.t_s, level, text});
    // The list of moves is there for who came late or lost the frame of a move.
    for (const table of [...(now.table_moves ?? []), now.table]) {
      const key = `${table?.term}:${table?.revision}`;
      if (!(table?.moved_max_m > MOVED_M) || this.tables.has(key)) continue;
      this.tables.add(key);
      out.push({t_s: table.t_s ?? now.t_s, level: 'note', text: moved_text(table)});
    }
    if (!before) return out;
    if (now.anchor?.vehicle && now.anchor.vehicle !== before.anchor?.vehicle) {
      event('note', `${now.anchor.vehicle} is the anchor${now.term === undefined ? '' : ` (term ${now.term})`}.`);
    }
    if (now.anchor?.lost && !before.anchor?.lost) event('error', `Anchor ${now.anchor.lost.vehicle} is lost.`);
    if (!now.anchor?.lost && before.anchor?.lost) event('ok', 'The anchor is heard again.');
    const old = new Set((before.diagnostics ?? []).map((d) => d.level + d.name + (d.vehicle ?? '')));
    for (const d of now.diagnostics ?? []) {
      if (d.level === 'error' && d.name !== 'anchor' && !old.has(d.level + d.name + (d.vehicle ?? ''))) event('error', d.message);
    }
    if (now.mission?.finished && !before.mission?.finished) event('ok', 'The mission is finished.');
    return out;
  }
}

function moved_text(table) {
  const whose = table.moved_vehicle ? ` (${table.moved_vehicle})` : '';
  const poses = table.moved_poses ? ` ${table.moved_poses} poses changed.` : '';
  return `Table ${table.revision} moved the map by up to ${table.moved_max_m.toFixed(2)} m${whose}.${poses}`;
}
