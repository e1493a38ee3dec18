// The words and tables beside the map.
import {DEGENERATE, link_colour, vehicle_colour} from './colours.js';
import {by_id, el, table} from './dom.js';
import {ago, bytes, clock, DASH, metres, milliseconds, number, percent, rate} from './format.js';

const OLD_S = 3;

export function show_state(state, on_vehicle) {
  by_id('who').textContent = state.vehicle ?? '';
  by_id('mission').textContent = state.mission?.state ?? '';
  by_id('waits').textContent = state.waits_for ?? '';
  by_id('figures').replaceChildren(...figures(state));
  show_lost(state.anchor?.lost);
  by_id('vehicles').replaceChildren(...(state.vehicles ?? []).map((v, i) => vehicle_card(v, i, state, on_vehicle)));
  by_id('links').replaceChildren(...links(state.links ?? []));
  by_id('ranges').replaceChildren(...ranges(state.ranges ?? []));
  show_diagnostics(state.diagnostics);
  by_id('machine').replaceChildren(...machine(state));
  for (const id of ['links', 'ranges', 'machine']) by_id(id).closest('details').hidden = by_id(id).childElementCount === 0;
}

function figures(state) {
  const figure = (name, value) => el('div', 'figure', el('b', '', value), el('span', '', name));
  const out = [];
  if (state.mission?.round !== undefined) out.push(figure('round', String(state.mission.round)));
  if (state.anchor?.vehicle) out.push(figure(state.term === undefined ? 'anchor' : `anchor, term ${state.term}`, state.anchor.vehicle));
  if (state.mission?.distance_m !== undefined) out.push(figure('driven', number(state.mission.distance_m, 0, 'm')));
  if (state.mission?.area_m2 !== undefined) out.push(figure('area', number(state.mission.area_m2, 0, 'm²')));
  return out;
}

function show_lost(lost) {
  const box = by_id('lost');
  box.hidden = !lost;
  if (!lost) return;
  const place = lost.position_m ? `at x ${lost.position_m[0].toFixed(1)} m, y ${lost.position_m[1].toFixed(1)} m` : 'at an unknown place';
  box.replaceChildren(
    el('h2', '', `Anchor ${lost.vehicle} is lost`),
    el('p', '', lost.message ?? ''),
    el('p', '', `Last seen ${ago(lost.age_s)} ago ${place}.`),
    lost.command ? el('p', 'order', 'If it will not come back: ', el('code', '', lost.command)) : null);
}

function vehicle_card(v, index, state, on_vehicle) {
  const anchor = state.anchor?.vehicle === v.name;
  const old = v.age_s > OLD_S;
  const card = el('button', old ? 'card old' : 'card');
  card.style.setProperty('--colour', vehicle_colour(index));
  const chips = [anchor ? chip('anchor', 'strong') : v.role && v.role !== 'tag' ? chip(v.role) : null,
    v.mode ? chip(v.mode) : null,
    v.degenerate ? chip('degenerate', 'open') : null,
    v.frame === 'local' ? chip('not in map yet', 'open') : null,
    old ? chip(`heard ${ago(v.age_s)} ago`, 'bad') : null];
  const sigma = v.ellipse ? `± ${metres(v.ellipse.major_m)}` : null;
  const facts = [sigma, v.at_rest ? 'at rest' : Number.isFinite(v.speed_mps) ? number(v.speed_mps, 1, 'm/s') : null,
    Number.isFinite(v.battery) ? `battery ${percent(v.battery)}` : null].filter(Boolean).join('  ·  ');
  card.append(el('div', 'top', el('b', '', v.name), ...chips.filter(Boolean)), el('div', 'facts', facts));
  if (v.waits_for) card.append(el('p', '', v.waits_for));
  card.addEventListener('click', () => on_vehicle(v));
  return card;
}

const chip = (text, kind = '') => el('span', `chip ${kind}`, text);

function links(list) {
  if (!list.length) return [];
  return [table(['link', 'loss', 'rate', 'delay'], list.map((l) => {
    const kind = l.connected ? '' : 'bad';
    const name = el('span', 'pair', el('i', 'dot'), `${l.from} → ${l.to}`);
    name.firstChild.style.background = link_colour(l);
    return [{text: name}, {text: l.connected ? percent(l.loss) : 'cut', kind}, rate(l.rate_Bps), milliseconds(l.delay_s)];
  }))];
}

function ranges(list) {
  if (!list.length) return [];
  return [table(['range', 'distance', 'use'], list.map((r) => [
    `${r.from} – ${r.to}`, metres(r.range_m), {text: r.used ? 'used' : r.reason ?? 'not used', kind: r.used ? 'good words' : 'words'},
  ]))];
}

function show_diagnostics(list) {
  const box = by_id('diagnostics');
  box.closest('details').hidden = list === undefined;
  const shown = (list ?? []).filter((d) => d.level !== 'ok');
  const order = {error: 0, stale: 1, warn: 2};
  shown.sort((a, b) => (order[a.level] ?? 3) - (order[b.level] ?? 3));
  const fine = (list ?? []).length - shown.length;
  const lines = shown.map((d) => el('li', d.level, el('b', '', [d.vehicle, d.name].filter(Boolean).join(' ')), el('span', '', d.message ?? ''),
    d.remedy ? el('em', '', d.remedy) : null));
  if (fine > 0 || !shown.length) lines.push(el('li', 'ok', el('span', '', fine ? `${fine} checks are in order.` : 'Nothing to report.')));
  box.replaceChildren(...lines);
  const count = by_id('diagnostics-count');
  count.textContent = shown.length ? String(shown.length) : '';
  count.className = shown.some((d) => d.level === 'error') ? 'count bad' : 'count';
}

function machine(state) {
  const out = [];
  if (state.sensors?.length) {
    out.push(table(['sensor', 'rate', 'gaps', 'drops', 'age'], state.sensors.map((s) => {
      const slow = s.expected_hz && s.rate_hz < 0.8 * s.expected_hz;
      return [s.name, {text: number(s.rate_hz, 1, 'Hz'), kind: slow ? 'bad' : ''}, String(s.gaps ?? DASH),
        {text: String(s.drops ?? DASH), kind: s.drops > 0 ? 'look' : ''}, {text: ago(s.age_s), kind: s.age_s > 1 ? 'bad' : ''}];
    })));
  }
  const lines = [];
  const line = (name, value, kind = '') => lines.push(el('div', 'line', el('span', '', name), el('b', kind, value)));
  if (state.steps) line('step p50, p99, longest', [state.steps.p50_s, state.steps.p99_s, state.steps.max_s].map(milliseconds).join(', '), state.steps.p99_s > 0.002 ? 'look' : '');
  if (state.odometry) line('scan to odom p50, p99', [state.odometry.latency_p50_s, state.odometry.latency_p99_s].map(milliseconds).join(', '));
  if (state.table) line('table', `revision ${state.table.revision}, ${state.table.poses ?? DASH} poses, ${ago(state.table.age_s)} old`);
  if (state.disk) line('disk free', `${bytes(state.disk.free_bytes)}${state.disk.state && state.disk.state !== 'ok' ? `, ${state.disk.state}` : ''}`, state.disk.state && state.disk.state !== 'ok' ? 'bad' : '');
  if (state.epoch !== undefined) line('start of the program', `epoch ${state.epoch}`);
  if (lines.length) out.push(el('div', 'lines', ...lines));
  if (state.disk?.message) out.push(el('p', 'bad', state.disk.message));
  return out;
}

/** What happened, newest first; a click goes back to it. */
export function show_events(events, start_s, on_event) {
  by_id('events').closest('details').hidden = !events.length;
  by_id('events').replaceChildren(...events.slice(-60).reverse().map((event) => {
    const line = el('button', `event ${event.level}`, el('span', '', clock(event.t_s - start_s)), event.text);
    line.addEventListener('click', () => on_event(event));
    return line;
  }));
}

const NOTE_MS = 8000;

/** A line above the map that goes by itself. */
export function announce(event) {
  const note = el('div', `note ${event.level}`, event.text);
  by_id('notes').append(note);
  while (by_id('notes').childElementCount > 3) by_id('notes').firstChild.remove();
  setTimeout(() => note.remove(), NOTE_MS);
}

export const legend_entry = (colour, text) => {
  const swatch = el('i');
  swatch.style.background = colour;
  return el('span', '', swatch, text);
};

export const degenerate_legend = () => legend_entry(DEGENERATE, 'degenerate');
