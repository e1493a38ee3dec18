// The map from above or from the side: cloud, paths, degenerate stretches, anchors, frontiers.
import {FONT, place, short_number, tick_texts} from './plots.js';
import uPlot from 'uplot';
import {colour_choice, on_colour, picture_of, rgb_of} from './cloud.js';
import {held_by, is_degenerate, row_at, stretches_of} from './page_data.js';
import {on_time, show_time} from './places.js';

const NAMES = ['x', 'y', 'z'];
const TRUE_NAMES = ['true_x', 'true_y', 'true_z'];
const [LEFT, RIGHT, TOP, BOTTOM] = [58, 10, 8, 42];
/** What held the vehicle on a degenerate stretch: width and dashes tell them apart on grey paper. */
const HELD = [null, ['#d55e0080', [3, 5]], ['#d55e00b0', [12, 7]], ['#c0161d', []]];

function bounds_of(page, vehicles, axes, with_cloud) {
  const box = [0, 1].map((n) => {
    const axis = axes[n];
    let [low, high] = with_cloud ? [page.cloud.low_m[axis], page.cloud.high_m[axis]] : [Infinity, -Infinity];
    for (const v of vehicles) {
      for (const value of v[NAMES[axis]] ?? []) {
        if (value !== null) [low, high] = [Math.min(low, value), Math.max(high, value)];
      }
    }
    const pad = Math.max(0.02 * (high - low), n === 0 ? 1 : 0.5);
    return [low - pad, high + pad];
  });
  return Number.isFinite(box[0][0]) && Number.isFinite(box[1][0]) ? box : null;
}

/** Equal scale on both axes, as wide as the page or as high as allowed; a flat side view is
 *  stretched by a whole number. */
function layout(box, width, spec) {
  const inner = width - LEFT - RIGHT;
  let [[x0, x1], [y0, y1]] = box;
  let scale = inner / (x1 - x0);
  let stretch = 1;
  if (spec.stretch) stretch = Math.min(Math.max(Math.floor(110 / ((y1 - y0) * scale)), 1), 10);
  const limit = spec.height_max;
  if ((y1 - y0) * scale * stretch > limit) {
    scale = limit / ((y1 - y0) * stretch);
    const more = (inner / scale - (x1 - x0)) / 2;
    [x0, x1] = [x0 - more, x1 + more];
  }
  const height = Math.max((y1 - y0) * scale * stretch, 60);
  const more = (height / (scale * stretch) - (y1 - y0)) / 2;
  return {x: [x0, x1], y: [y0 - more, y1 + more], height: Math.round(height + TOP + BOTTOM), stretch};
}

class MapDrawing {
  constructor(page, spec) {
    Object.assign(this, {page, spec, axes: spec.axes});
    this.vehicles = page.vehicles.filter((v) => spec.group === '*' || v.group === spec.group);
    this.with_cloud = Boolean(spec.cloud && page.cloud);
    this.box = bounds_of(page, this.vehicles, this.axes, this.with_cloud);
    this.spots = spec.group === 'map' ? (page.spots ?? []) : [];
  }

  pixel(u, point) {
    return [u.valToPos(point[this.axes[0]], 'x', true), u.valToPos(point[this.axes[1]], 'y', true)];
  }

  point(v, k, names = NAMES) {
    const point = names.map((name) => v[name]?.[k] ?? null);
    return point[0] === null ? null : point;
  }

  draw_cloud(u) {
    if (!this.with_cloud) return;
    const {left, top, width, height} = u.bbox;
    const window = {x0: u.scales.x.min, x1: u.scales.x.max, y0: u.scales.y.min, y1: u.scales.y.max};
    const zoom = this.width_m / (window.x1 - window.x0);
    const pixels = [width, height].map((n) => Math.max(Math.round(n / uPlot.pxRatio * 1.3), 1));
    const by = colour_choice();
    const picture = picture_of(this.page.cloud, rgb_of(this.page.cloud, this.vehicles, by), by, {
      axes: [...this.axes, 3 - this.axes[0] - this.axes[1]], window, width: pixels[0], height: pixels[1],
      size: Math.min(Math.max(Math.round(Math.sqrt(zoom)), 1), 5),
    });
    u.ctx.imageSmoothingEnabled = false;
    u.ctx.drawImage(picture, left, top, width, height);
  }

  stroke(u, v, first, last, names, colour, width, dash) {
    const {ctx} = u;
    ctx.strokeStyle = colour;
    ctx.lineWidth = width * uPlot.pxRatio;
    ctx.setLineDash(dash.map((n) => n * uPlot.pxRatio));
    ctx.lineJoin = 'round';
    ctx.beginPath();
    let before = null;
    for (let k = first; k <= last; ++k) {
      const point = this.point(v, k, names);
      if (!point) continue;
      const [x, y] = this.pixel(u, point);
      // A stretch that was cut out is not bridged.
      if (before === null || v.t[k] - v.t[before] > this.hole_s(v)) ctx.moveTo(x, y);
      else ctx.lineTo(x, y);
      before = k;
    }
    ctx.stroke();
    ctx.setLineDash([]);
  }

  hole_s(v) {
    return Math.max(2, (4 * (v.t[v.rows - 1] - v.t[0])) / v.rows);
  }

  draw_paths(u) {
    for (const v of this.vehicles) {
      if (v.true_x) this.stroke(u, v, 0, v.rows - 1, TRUE_NAMES, '#6e747e', 2.6, [3, 3]);
    }
    // Runs side by side may have one path: the first is wider and shows below the others.
    const widths = this.vehicles.map((_, i) => (this.page.spots ? 2.2 : 2.2 + 1.8 * (this.vehicles.length - 1 - i)));
    for (const [i, v] of this.vehicles.entries()) {
      const held = (s) => (is_degenerate(s) ? Math.max(held_by(s), 1) : null);
      for (const [first, last, by] of stretches_of(v, held)) {
        this.stroke(u, v, first, last, NAMES, HELD[by][0], 10, HELD[by][1]);
      }
      this.stroke(u, v, 0, v.rows - 1, NAMES, '#ffffffc0', widths[i] + 1.8, []);
      this.stroke(u, v, 0, v.rows - 1, NAMES, v.colour, widths[i], v.dash);
    }
  }

  /** Start (ring) and end (square) of each path with its name; names evade each other. */
  draw_names(u) {
    const {ctx} = u;
    const r = uPlot.pxRatio;
    const taken = [];
    ctx.font = `bold ${13 * r}px system-ui, Arial, sans-serif`;
    for (const v of this.vehicles) {
      const known = v.t.map((_, k) => k).filter((k) => this.point(v, k));
      if (!known.length) continue;
      const [sx, sy] = this.pixel(u, this.point(v, known[0]));
      const [ex, ey] = this.pixel(u, this.point(v, known[known.length - 1]));
      ctx.lineWidth = 2.5 * r;
      [ctx.strokeStyle, ctx.fillStyle] = [v.colour, '#ffffff'];
      ctx.beginPath();
      ctx.arc(sx, sy, 4 * r, 0, 7);
      ctx.fill();
      ctx.stroke();
      ctx.fillStyle = v.colour;
      ctx.fillRect(ex - 4 * r, ey - 4 * r, 8 * r, 8 * r);
      const width = ctx.measureText(v.name).width;
      const right = u.bbox.left + u.bbox.width;
      const x = ex + 8 * r + width > right ? ex - 8 * r - width : ex + 8 * r;
      let y = ey - 6 * r;
      const step = y + 60 * r > u.bbox.top + u.bbox.height ? -15 * r : 15 * r;
      while (taken.some((t) => Math.abs(t.y - y) < 15 * r && x < t.x + t.width && t.x < x + width)) y += step;
      taken.push({x, y, width});
      [ctx.strokeStyle, ctx.lineWidth, ctx.fillStyle] = ['#ffffff', 3.5 * r, '#1c2430'];
      ctx.strokeText(v.name, x, y);
      ctx.fillText(v.name, x, y);
    }
  }

  /** A bar of 1 sigma to both sides where it is long enough to be seen, else an arrow. */
  draw_axis(u, spot) {
    const r = uPlot.pxRatio;
    const [x, y] = this.pixel(u, spot.p);
    const end = this.pixel(u, spot.p.map((p, n) => p + spot.axis[n]));
    const length = Math.hypot(end[0] - x, end[1] - y);
    const per_m = (u.bbox.width / (u.scales.x.max - u.scales.x.min));
    if (!(length > 0.3 * per_m)) return;  // it points at the reader
    const [ux, uy] = [(end[0] - x) / length, (end[1] - y) / length];
    const half = Math.min(spot.off_m * length, 1e4);
    const sized = half > 7 * r;
    const [h, cap] = sized ? [half, 6 * r] : [11 * r, 3.5 * r];
    const beside = sized ? 0 : 13 * r;
    const [mx, my] = [x + uy * beside, y - ux * beside];
    const path = new Path2D();
    path.moveTo(mx - h * ux, my - h * uy);
    path.lineTo(mx + h * ux, my + h * uy);
    for (const side of [-1, 1]) {
      const [ex, ey] = [mx + side * h * ux, my + side * h * uy];
      const back = sized ? 0 : side * cap * 1.3;
      path.moveTo(ex - back * ux - cap * uy, ey - back * uy + cap * ux);
      path.lineTo(ex, ey);
      path.lineTo(ex - back * ux + cap * uy, ey - back * uy - cap * ux);
    }
    for (const [colour, width] of [['#ffffffd8', 4.5], ['#14181f', 1.7]]) {
      [u.ctx.strokeStyle, u.ctx.lineWidth] = [colour, width * r];
      u.ctx.stroke(path);
    }
  }

  draw_spots(u) {
    const r = uPlot.pxRatio;
    for (const spot of this.spots) {
      const [x, y] = this.pixel(u, spot.p);
      if (spot.p[this.axes[1]] === null || !Number.isFinite(x) || !Number.isFinite(y)) continue;
      if (spot.kind === 'axis') { this.draw_axis(u, spot); continue; }
      const frontier = spot.kind === 'frontier';
      const shape = frontier ? [[0, -5], [5, 0], [0, 5], [-5, 0]] : [[0, -7], [6, 4], [-6, 4]];
      u.ctx.beginPath();
      for (const [dx, dy] of shape) u.ctx.lineTo(x + dx * r, y + dy * r);
      u.ctx.closePath();
      [u.ctx.fillStyle, u.ctx.strokeStyle, u.ctx.lineWidth] = frontier
        ? ['#ffffff', '#14181f', 1.6 * r] : ['#1c2430', '#ffffff', 1.2 * r];
      u.ctx.fill();
      u.ctx.stroke();
    }
  }

  draw(u) {
    u.ctx.save();
    u.ctx.beginPath();
    u.ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    u.ctx.clip();
    this.draw_cloud(u);
    this.draw_paths(u);
    this.draw_spots(u);
    this.draw_names(u);
    u.ctx.restore();
    u.ctx.strokeStyle = '#aab4c0';
    u.ctx.strokeRect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
  }

  /** The selected window, widened to the frame's shape. */
  zoom(u) {
    const {left, top, width, height} = u.select;
    if (width < 8 && height < 8) return;
    const ratio = (u.bbox.width / u.bbox.height);
    const w = Math.max(width, height * ratio);
    const h = w / ratio;
    const x = left + width / 2 - w / 2;
    const y = top + height / 2 - h / 2;
    const to = {x: [u.posToVal(x, 'x'), u.posToVal(x + w, 'x')], y: [u.posToVal(y + h, 'y'), u.posToVal(y, 'y')]};
    u.setSelect({left: 0, top: 0, width: 0, height: 0}, false);
    this.show(u, to);
  }

  show(u, window) {
    u.batch(() => {
      u.setScale('x', {min: window.x[0], max: window.x[1]});
      u.setScale('y', {min: window.y[0], max: window.y[1]});
    });
  }

  /** What lies under the pointer: a spot, else the nearest pose. */
  under(u) {
    const [left, top] = [u.cursor.left, u.cursor.top];
    if (!(left >= 0)) return null;
    let best = {distance: 14};
    const see = (point, found) => {
      if (!point || point[this.axes[1]] === null) return;
      const x = u.valToPos(point[this.axes[0]], 'x');
      const y = u.valToPos(point[this.axes[1]], 'y');
      const distance = Math.hypot(x - left, y - top);
      if (distance < best.distance) best = {distance, ...found};
    };
    for (const spot of this.spots) see(spot.p, {text: spot.text});
    if (best.text) return best;
    for (const v of this.vehicles) {
      for (let k = 0; k < v.rows; ++k) see(this.point(v, k), {v, k});
    }
    return best.v ? {...best, text: pose_text(best.v, best.k)} : null;
  }

  hover(u) {
    const found = this.under(u);
    const x = u.cursor.left >= 0 ? u.posToVal(u.cursor.left, 'x') : null;
    const y = u.cursor.left >= 0 ? u.posToVal(u.cursor.top, 'y') : null;
    this.readout.textContent = found ? found.text
      : x === null ? '\u00a0' : `${NAMES[this.axes[0]]} ${short_number(x)} m, ${NAMES[this.axes[1]]} ${short_number(y)} m`;
    if (!found?.v) return;
    show_time([found.v], found.v.t[found.k]);
    for (const plot of uPlot.sync(`vehicle${this.page.vehicles.indexOf(found.v)}`).plots) {
      plot.setCursor({left: plot.valToPos(plot.data[0][found.k], 'x'), top: 0});
    }
  }

  /** Rings where the vehicles are at a time. */
  mark(u, vehicles, t_s) {
    for (const ring of u.over.querySelectorAll('.place')) ring.remove();
    if (t_s === null) return;
    for (const v of vehicles) {
      const point = this.vehicles.includes(v) ? this.point(v, row_at(v, t_s)) : null;
      if (!point) continue;
      const ring = document.createElement('div');
      ring.className = 'place';
      ring.style.borderColor = v.colour;
      ring.style.left = `${u.valToPos(point[this.axes[0]], 'x')}px`;
      ring.style.top = `${u.valToPos(point[this.axes[1]], 'y')}px`;
      u.over.append(ring);
    }
  }
}

function pose_text(v, k) {
  const numbers = NAMES.map((name) => `${name} ${short_number(v[name][k] ?? 0)}`).join(', ');
  const sigma = v.sigma?.[k] ? `, ± ${short_number(v.sigma[k])} m (1 sigma)` : '';
  return `${v.name} at ${v.t[k].toFixed(1)} s: ${numbers} m${sigma}`;
}

function options(map, width, at) {
  const axis = (label, more) => ({label, labelFont: FONT, font: FONT, labelGap: 0, gap: 3, stroke: '#3c4654',
    values: tick_texts, grid: {show: false}, ticks: {size: 4, stroke: '#7b8694'}, ...more});
  const up = NAMES[map.axes[1]];
  return {
    width, height: at.height, padding: [TOP, RIGHT, 0, 0], legend: {show: false},
    scales: {x: {time: false, range: (u, low, high) => [low, high]}, y: {range: (u, low, high) => [low, high]}},
    axes: [axis(`${NAMES[map.axes[0]]} of the map [m]`, {size: 22, labelSize: BOTTOM - 22}),
      axis(at.stretch > 1 ? `${up} [m], ${at.stretch} x` : `${up} [m]`,
        {size: LEFT - 18, labelSize: 18, space: 26})],
    series: [{}, {paths: () => null, points: {show: false}}],
    cursor: {
      drag: {x: true, y: true, dist: 5, setScale: false}, points: {show: false},
      bind: {dblclick: (u) => () => { map.show(u, map.all); return null; }},
    },
    hooks: {
      drawAxes: [(u) => map.draw(u)], setSelect: [(u) => map.zoom(u)], setCursor: [(u) => map.hover(u)],
    },
  };
}

/** spec: group of vehicles or '*', axes, cloud, stretch, height_max. */
export function draw_map(holder, page, spec) {
  const map = new MapDrawing(page, spec);
  if (!map.box) return null;
  map.readout = document.createElement('p');
  map.readout.className = 'readout';
  map.readout.textContent = '\u00a0';
  const plot = place(holder, (width) => {
    const at = layout(map.box, width, spec);
    map.all = at;
    map.width_m = at.x[1] - at.x[0];
    return new uPlot(options(map, width, at), [at.x, at.y], holder);
  });
  plot.rali_fit = (width) => {
    map.all = layout(map.box, width, spec);
    map.width_m = map.all.x[1] - map.all.x[0];
    plot.setSize({width, height: map.all.height});
    map.show(plot, map.all);
  };
  holder.append(map.readout);
  on_colour(() => plot.redraw(false));
  on_time((vehicles, t_s) => map.mark(plot, vehicles, t_s));
  return plot;
}
