// Plots over time or distance: lines, dots and rows of states, drawn by uPlot.
import './sharp.js';
import uPlot from 'uplot';
import {held_by, is_degenerate, row_at, sight, stretches_of, UNKNOWN} from './page_data.js';
import {show_time} from './places.js';
import {pattern_of} from './patterns.js';

export const FONT = '12px system-ui, Arial, sans-serif';
const PAPER_PX = 690;  // width of A4 less its margins
const LEFT_PX = 62;

/** Four digits that mean something. */
export function short_number(value) {
  const size = Math.abs(value);
  if (size !== 0 && size < 1e-3) return value.toExponential(1);
  return value.toFixed(size >= 100 ? 1 : size >= 1 ? 2 : 3);
}

export const tick_texts = (u, ticks) => ticks.map((v) => (v === null ? '' : String(+v.toPrecision(6))));

/** A plot as wide as its place; on paper as wide as the paper. */
export function place(holder, make) {
  let plot = null;
  let last = Math.max(holder.clientWidth, 200);
  const fit = (width) => {
    if (width < 50 || Math.abs(width - last) < 1) return;
    last = width;
    if (plot?.rali_fit) plot.rali_fit(width);
    else plot?.setSize({width, height: plot.height});
  };
  plot = make(last);
  if (!plot) return null;
  const observer = new ResizeObserver(() => fit(holder.clientWidth));
  observer.observe(holder);
  const columns = holder.parentElement?.classList.contains('plots') ? 2 : 1;
  const to_paper = () => fit(columns === 2 ? (PAPER_PX - 14) / 2 : PAPER_PX);
  const to_screen = () => fit(holder.clientWidth);
  window.addEventListener('beforeprint', to_paper);
  window.addEventListener('afterprint', to_screen);
  plot.hooks.destroy = [() => {
    observer.disconnect();
    window.removeEventListener('beforeprint', to_paper);
    window.removeEventListener('afterprint', to_screen);
  }];
  return plot;
}

function x_axis(label) {
  return {label, labelFont: FONT, font: FONT, size: 24, labelSize: 20, labelGap: 0, gap: 3,
    stroke: '#3c4654', values: tick_texts, grid: {stroke: '#e6eaef'}, ticks: {size: 4, stroke: '#aab4c0'}};
}

/** Of a logarithmic axis powers of ten, with few of them 1, 2 and 5 of each, with fewer all digits. */
function log_ticks(u, axis, low, high) {
  const decades = Math.log10(high / low);
  const digits = decades > 1.5 ? [1] : decades > 0.6 ? [1, 2, 5] : [1, 2, 3, 4, 5, 6, 7, 8, 9];
  const ticks = [];
  for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high) && ticks.length < 40; ++e) {
    for (const digit of digits) {
      const v = +`${digit}e${e}`;
      if (v >= low && v <= high) ticks.push(v);
    }
  }
  return ticks;
}

function y_axis(label, log) {
  const axis = {...x_axis(label), size: LEFT_PX - 16, labelSize: 16, space: 24};
  if (!log) return axis;
  const all = (u, ticks) => ticks;
  return {...axis, splits: log_ticks, filter: all, grid: {...axis.grid, filter: all}, ticks: {...axis.ticks, filter: all}};
}

/** Hatches the stretches where the LiDAR is degenerate. */
function shade(u, vehicle, x) {
  u.ctx.fillStyle = pattern_of(u.ctx, 'shade');
  for (const [first, last] of stretches_of(vehicle, (s) => (is_degenerate(s) ? 1 : null))) {
    const left = u.valToPos(x[first], 'x', true);
    const right = u.valToPos(x[last], 'x', true);
    const [a, b] = [Math.max(left, u.bbox.left), Math.min(right, u.bbox.left + u.bbox.width)];
    if (b >= a) u.ctx.fillRect(a, u.bbox.top, Math.max(b - a, 1), u.bbox.height);
  }
}

function cursor_options(key) {
  return {
    y: false, drag: {x: true, y: false, dist: 5},
    hover: {prox: 25, skip: [null, undefined]},
    points: {size: 6}, sync: {key, scales: ['x', null]},
  };
}

/** Shows on the maps where the vehicles are at the time under the cursor. */
function follow(vehicles, times) {
  return (u) => {
    const k = u.cursor.idx;
    const inside = k !== null && k !== undefined && u.cursor.left >= 0;
    u.root.classList.toggle('live', inside);
    show_time(vehicles, inside ? times[k] : null);
  };
}

/** At least from half to double, so that noise does not fill the frame. */
function log_range(low, high) {
  const middle = Math.sqrt(low * high);
  return [Math.min(low / 1.2, middle / 2), Math.max(high * 1.2, middle * 2)];
}

function y_range(spec) {
  return (u, low, high) => {
    if (low === null || high === null) return spec.log ? [0.1, 10] : [0, 1];
    if (spec.log) return log_range(Math.max(low, high * 1e-3), high);
    const pad = Math.max(0.06 * (high - low), 0.5 * (spec.least ?? 1e-3));
    return [spec.from_zero ? 0 : low - pad, high + pad];
  };
}

function series_options(s, unit) {
  const dots = s.dots ? {paths: () => null, points: {show: true, size: s.size ?? 3, width: 0, fill: s.colour}}
    : {points: {show: false}};
  return {
    label: s.label, stroke: s.colour, width: s.width ?? 1.4, dash: s.dash ?? [], class: s.class,
    value: (u, v) => (v === null || v === undefined ? '' : `${short_number(v)} ${unit}`), ...dots,
  };
}

function draw_mark(u, mark) {
  const y = u.valToPos(mark, 'y', true);
  if (!(y >= u.bbox.top && y <= u.bbox.top + u.bbox.height)) return;
  u.ctx.setLineDash([8, 6]);
  u.ctx.strokeStyle = '#5b6675';
  u.ctx.beginPath();
  u.ctx.moveTo(u.bbox.left, y);
  u.ctx.lineTo(u.bbox.left + u.bbox.width, y);
  u.ctx.stroke();
  u.ctx.setLineDash([]);
}

/**
 * Lines over a common x. spec: title, unit, x, x_label, series [{label, values, colour, dash, dots}],
 * sync, vehicles and times for the map, shaded vehicle, mark, log, from_zero, least, height.
 */
export function line_plot(holder, spec) {
  const value_text = (u, v) => (v === null || v === undefined ? '' : short_number(v));
  const draw = spec.log ? (v) => (v > 0 ? v : null) : (v) => v;
  const data = [spec.x, ...spec.series.map((s) => s.values.map((v) => (v === null || v === undefined ? v : draw(v))))];
  return place(holder, (width) => new uPlot({
    title: spec.title, class: spec.series.length === 1 ? 'single' : 'several', width, height: spec.height ?? 170, padding: [6, 8, 0, 0],
    scales: {x: {time: false}, y: {distr: spec.log ? 3 : 1, range: y_range(spec)}},
    axes: [x_axis(spec.x_label), y_axis(spec.y_label ?? `[${spec.unit}]`, spec.log)],
    series: [{label: spec.x_label.split(' [')[0], value: value_text},
      ...spec.series.map((s) => series_options(s, spec.unit))],
    legend: {markers: {dash: (u, i) => (u.series[i].dash?.length ? 'dashed' : 'solid'), width: (u, i) => (spec.marks ? 0 : u.series[i].width)}},
    cursor: cursor_options(spec.sync),
    hooks: {
      drawClear: spec.shaded ? [(u) => shade(u, spec.shaded, spec.x)] : [],
      draw: [(u) => { if (spec.mark !== undefined) draw_mark(u, spec.mark); spec.draw?.(u); }],
      setCursor: [follow(spec.vehicles, spec.times ?? spec.x)],
    },
  }, data, holder));
}

const SIGHT_KINDS = ['good', 'partial', 'degenerate'];
const SIGHT_WORDS = ['all directions observed', 'one direction weak', 'degenerate along one axis'];
const HELD_KINDS = ['good', 'by_range', 'by_imu', 'by_nothing'];
const HELD_WORDS = ['LiDAR', 'ranges', 'inertia alone', 'nothing'];

/** Rows of a vehicle: what the LiDAR observes, what held the vehicle, which ranges came. */
function rows_of(vehicle, x) {
  const bars = (value_of, kinds) => stretches_of(vehicle, value_of)
    .map(([first, last, value]) => [x[first], x[last], kinds[value]]);
  const rows = [
    {label: 'LiDAR', bars: bars((s) => (s === UNKNOWN ? null : sight(s)), SIGHT_KINDS),
      words: (k) => SIGHT_WORDS[sight(vehicle.state[k])]},
    {label: 'constrained by', bars: bars((s) => (s === UNKNOWN ? null : held_by(s)), HELD_KINDS),
      words: (k) => HELD_WORDS[held_by(vehicle.state[k])]},
  ];
  for (const [label, at] of [['used', 2], ['rejected', 3]]) {
    const row = {label: `ranges ${label}`, bars: [], words: () => ''};
    for (let i = 0; i + 3 < (vehicle.received?.length ?? 0); i += 4) {
      const part = vehicle.received.slice(i, i + 4);
      const [from, to] = [0, 1].map((n) => x[row_at(vehicle, part[n])]);
      if (part[at] > 0) row.bars.push([from, to, label]);
    }
    if (row.bars.length) rows.push(row);
  }
  return rows;
}

export const held_row = (vehicle) => ({...rows_of(vehicle, vehicle.t)[1], label: vehicle.name});

function draw_rows(u, rows) {
  const height = u.bbox.height / rows.length;
  // A bar is at least a pixel wide and bad ones lie on top: none is hidden.
  const badness = (kind) => ['degenerate', 'by_nothing', 'anchor'].indexOf(kind);
  rows.forEach((row, i) => {
    for (const [from, to, kind] of [...row.bars].sort((a, b) => badness(a[2]) - badness(b[2]))) {
      const left = Math.max(u.valToPos(from, 'x', true), u.bbox.left);
      const right = Math.min(u.valToPos(to, 'x', true), u.bbox.left + u.bbox.width);
      if (right < u.bbox.left || left > u.bbox.left + u.bbox.width) continue;
      u.ctx.fillStyle = pattern_of(u.ctx, kind);
      u.ctx.fillRect(left, u.bbox.top + i * height + 3, Math.max(right - left, 2), height - 6);
    }
  });
}

/** Rows of bars. spec: rows [{label, bars [from, to, kind], words}], x, x_label, sync, ... */
export function rows_plot(holder, spec) {
  const count = spec.rows.length;
  const nothing = spec.x.map(() => 0);
  const options = (width) => ({
    class: 'single', width, height: 46 + 22 * count, padding: [4, 8, 0, 0],
    scales: {x: {time: false}, y: {range: [0, count]}},
    axes: [x_axis(spec.x_label), {...y_axis(null), size: spec.left ?? 104, grid: {show: false}, ticks: {show: false},
      splits: () => spec.rows.map((row, i) => count - i - 0.5), values: () => spec.rows.map((row) => row.label)}],
    series: [{label: spec.x_label.split(' [')[0], value: (u, v) => (v === null || v === undefined ? '' : short_number(v))},
      ...spec.rows.map((row) => ({label: row.label, paths: () => null, points: {show: false},
        class: row.words ? undefined : 'no-key',
        value: (u, v, i, k) => (k === null || k === undefined ? '' : row.words?.(k) ?? '')}))],
    cursor: {...cursor_options(spec.sync), points: {show: false}},
    hooks: {draw: [(u) => draw_rows(u, spec.rows)], setCursor: [follow(spec.vehicles, spec.times ?? spec.x)]},
  });
  return place(holder, (width) => new uPlot(options(width), [spec.x, ...spec.rows.map(() => nothing)], holder));
}

export function state_rows_plot(holder, vehicle, x, x_label, sync) {
  return rows_plot(holder, {rows: rows_of(vehicle, x), x, x_label, sync, vehicles: [vehicle], times: vehicle.t});
}

const LOOKS = [['#7dacd6', 'dot', '•'], ['#b22200', 'cross', '×'], ['#78288c', 'triangle', '△'], ['#1e1e1e', 'square', '□'],
  ['#007258', 'diamond', '◇'], ['#96700a', 'plus', '+']];

function mark_path(ctx, shape, x, y, r) {
  ctx.beginPath();
  if (shape === 'dot') ctx.arc(x, y, 0.6 * r, 0, 7);
  const lines = {
    cross: [[-1, -1], [1, 1], null, [-1, 1], [1, -1]], plus: [[-1, 0], [1, 0], null, [0, -1], [0, 1]],
    triangle: [[-1, 0.8], [1, 0.8], [0, -1], [-1, 0.8]], square: [[-0.8, -0.8], [0.8, -0.8], [0.8, 0.8], [-0.8, 0.8], [-0.8, -0.8]],
    diamond: [[0, -1], [1, 0], [0, 1], [-1, 0], [0, -1]],
  }[shape] ?? [];
  let down = false;
  for (const at of lines) {
    if (at === null) down = false;
    else if (down) ctx.lineTo(x + r * at[0], y + r * at[1]);
    else { ctx.moveTo(x + r * at[0], y + r * at[1]); down = true; }
  }
}

/** Marks beyond the frame stand at its border; those without a value on its foot. */
function draw_marks(u, series) {
  const {left, top, width, height} = u.bbox;
  const r = 3 * uPlot.pxRatio;
  u.ctx.lineWidth = 1.2 * uPlot.pxRatio;
  for (const s of series) {
    const [colour, shape] = LOOKS[s.look];
    u.ctx.strokeStyle = u.ctx.fillStyle = colour;
    for (let i = 0; i < s.t.length; ++i) {
      const x = u.valToPos(s.t[i], 'x', true);
      if (!(x >= left && x <= left + width)) continue;
      const y = Number.isFinite(s.residual[i]) ? u.valToPos(s.residual[i], 'y', true) : top + height;
      mark_path(u.ctx, shape, x, Math.min(Math.max(y, top + 1), top + height), r);
      if (shape === 'dot') u.ctx.fill();
      else u.ctx.stroke();
    }
  }
}

/** Residuals of the ranges between two vehicles. */
export function residual_plot(holder, pair, end_s, vehicles) {
  const ends = [[0, end_s], [null, null]];
  const tables = pair.series.map((s) => [Array.from(s.t), Array.from(s.residual, (v) => (Number.isFinite(v) ? v : null))]);
  const [x, , ...values] = uPlot.join([ends, ...tables.map(([t, v]) => {
    const order = t.map((_, i) => i).filter((i) => i === 0 || t[i] > t[i - 1]);
    return [order.map((i) => t[i]), order.map((i) => v[i])];
  })]);
  const plot = line_plot(holder, {
    title: pair.name, unit: 'm', y_label: 'residual [m]', x, x_label: 'time [s]', height: 190, sync: 'fleet',
    vehicles, mark: 0, marks: true, draw: (u) => draw_marks(u, pair.series),
    series: pair.series.map((s, i) => ({label: `${LOOKS[s.look][2]} ${s.label}`, colour: LOOKS[s.look][0], values: values[i], dots: true, size: 0})),
  });
  plot?.setScale('y', {min: -pair.scale_m, max: pair.scale_m});
  return plot;
}

/** Values of several vehicles over time; from the seventh on they share one key. */
export function fleet_plot(holder, spec, vehicles) {
  const shown = vehicles.filter((v) => v[spec.column]);
  if (!shown.length) return null;
  const [times, ...values] = uPlot.join(shown.map((v) => [v.t, v[spec.column]]));
  const named = shown.length <= 6 ? shown.length : 5;
  return line_plot(holder, {
    ...spec, x: times, x_label: 'time [s]', sync: 'fleet', vehicles,
    series: shown.map((v, i) => ({
      label: i < named || shown.length <= 6 ? v.name : `${shown.length - named} others`,
      colour: i < named ? v.colour : '#aab4c0', dash: i < named ? v.dash : [], values: values[i],
      class: i > named ? 'no-key' : undefined,
    })),
  });
}
