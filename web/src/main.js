// Entry: numbers and sentences stand in the page without scripts; these draw its figures.
import './sharp.js';
import {start_choices} from './cloud.js';
import {draw_map} from './map.js';
import {read_page, stands, stretches_of} from './page_data.js';
import {fill_keys} from './patterns.js';
import {fleet_plot, held_row, line_plot, residual_plot, rows_plot, state_rows_plot} from './plots.js';
import {start_view} from './view3d.js';

const DOTS = {dots: true, size: 3};
const GREY = '#6e747e';

/** The plots of one vehicle; a column that is not known is left out. */
function vehicle_plots(v) {
  return [
    {title: 'height z', unit: 'm', series: [['z', 'z', v.colour]], least: 0.02},
    {title: 'speed', unit: 'm/s', series: [['speed', 'speed', v.colour]], from_zero: true, least: 0.02},
    {title: 'position error', unit: 'm', from_zero: true,
      series: [['sigma', 'expected (1 sigma)', v.colour], ['ape', 'measured', GREY, {dash: [3, 2]}]]},
    {title: 'error along the least observable direction', unit: 'm', log: true,
      series: [['off', 'expected (1 sigma)', '#006094'], ['along', 'measured where degenerate', '#d55e00', DOTS]]},
    {title: 'degree of degeneracy', unit: '', y_label: 'lambda2 / lambda3', log: true, series: [['degree', 'degree', v.colour]]},
    {title: 'heading of the least observable axis', unit: '°', series: [['heading', 'heading', '#5b6675', DOTS]], least: 10},
  ];
}

function draw_vehicle(holder, v, over, key) {
  const x = over === 'distance' ? v.distance : v.t;
  const x_label = over === 'distance' ? 'distance travelled [m]' : 'time [s]';
  const plots = [];
  const add = (parent, make) => {
    const figure = document.createElement('figure');
    parent.append(figure);
    const plot = make(figure);
    if (plot) plots.push(plot);
    else figure.remove();
  };
  if (v.state.some((s) => s !== 255)) add(holder, (f) => state_rows_plot(f, v, x, x_label, key));
  const grid = document.createElement('div');
  grid.className = 'plots';
  holder.append(grid);
  for (const plot of vehicle_plots(v)) {
    const series = plot.series.filter(([column]) => v[column]).map(([column, label, colour, more]) => (
      {label, colour, values: column === 'along' ? v.along.map((e) => e && Math.abs(e)) : v[column], ...more}));
    if (!series.length) continue;
    add(grid, (f) => line_plot(f, {...plot, series, x, x_label, sync: key, vehicles: [v], times: v.t, shaded: v}));
  }
  return plots;
}

function vehicle_figures(holder, page) {
  const v = page.vehicles[Number(holder.dataset.vehicle)];
  if (!v?.rows) return;
  const choice = document.getElementById('over');
  let plots = draw_vehicle(holder, v, choice?.value ?? 'time', `vehicle${holder.dataset.vehicle}`);
  choice?.addEventListener('change', () => {
    for (const plot of plots) plot.destroy();
    holder.replaceChildren();
    plots = draw_vehicle(holder, v, choice.value, `vehicle${holder.dataset.vehicle}`);
  });
}

const TRUTH_PLOTS = [
  {title: 'position error after the best fit', unit: 'm', column: 'ape', from_zero: true},
  {title: 'rotation error', unit: '°', column: 'rot', from_zero: true},
  {title: 'error in height', unit: 'm', column: 'ez'},
  {title: 'error along the degenerate axis', unit: 'm', column: 'along'},
  {title: 'error over its stated sigma (about 1 expected)', unit: '', y_label: 'ratio', column: 'ratio', log: true, mark: 1},
];

function role_rows(page) {
  return page.vehicles.filter((v) => v.rows).map((v) => {
    const bars = stretches_of(v, (s) => (s === 255 ? null : stands(s) ? 'stands' : 'drives'))
      .map(([first, last, kind]) => [v.t[first], v.t[last], kind]);
    for (const r of page.rounds) if (r.anchor === v.name) bars.push([r.begin_s, r.end_s, 'anchor']);
    return {label: v.name, bars};
  });
}

/** Each kind of figure that a page may hold: <figure data-figure="KIND" ...>. */
const FIGURES = {
  map: (holder, page) => draw_map(holder, page, {
    group: holder.dataset.group, axes: [0, 1], cloud: holder.dataset.cloud !== undefined, height_max: Number(holder.dataset.height ?? 620),
  }),
  side: (holder, page) => {
    const size = page.cloud ? [0, 1].map((n) => page.cloud.high_m[n] - page.cloud.low_m[n]) : [1, 0];
    return draw_map(holder, page, {group: 'map', axes: size[0] >= size[1] ? [0, 2] : [1, 2], cloud: true, stretch: true, height_max: 260});
  },
  view: (holder, page) => start_view(holder, page),
  held: (holder, page) => fleet_rows(holder, page, page.vehicles.filter((v) => v.rows).map(held_row)),
  roles: (holder, page) => fleet_rows(holder, page, role_rows(page)),
  vehicle: vehicle_figures,
  truth: (holder, page) => {
    for (const spec of TRUTH_PLOTS) {
      const figure = document.createElement('figure');
      holder.append(figure);
      if (!fleet_plot(figure, spec, page.vehicles)) figure.remove();
    }
  },
  residuals: (holder, page) => residual_plot(holder, page.pairs[Number(holder.dataset.pair)], page.end_s, page.vehicles),
};

function fleet_rows(holder, page, rows) {
  const times = Array.from({length: 601}, (_, i) => (i * page.end_s) / 600);
  for (const row of rows) delete row.words;
  return rows_plot(holder, {rows, x: times, x_label: 'time [s]', sync: 'fleet', vehicles: page.vehicles});
}

document.documentElement.dataset.scripts = 'running';
const page = read_page();
let drawn = 0;
if (page) {
  for (const holder of document.querySelectorAll('[data-figure]')) {
    FIGURES[holder.dataset.figure](holder, page);
    ++drawn;
  }
  fill_keys();
  start_choices();
}
document.documentElement.dataset.figures = drawn;
document.documentElement.dataset.scripts = 'done';
