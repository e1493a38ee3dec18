// The cloud of the map as a picture, and what colours its points.

const SLICES = 16;
const WEAKEST = 0.25;
const listeners = [];

/** What colours the points: one choice for all drawings of the page. */
export function colour_choice() {
  return document.querySelector('select.cloud-colour')?.value ?? 'height';
}

export function on_colour(listener) {
  listeners.push(listener);
}

export function start_choices() {
  const choices = [...document.querySelectorAll('select.cloud-colour')];
  const show = (value) => {
    for (const choice of choices) choice.value = value;
    for (const key of document.querySelectorAll('.keys [data-colour]')) key.hidden = key.dataset.colour !== value;
    for (const listener of listeners) listener(value);
  };
  for (const choice of choices) choice.addEventListener('change', () => show(choice.value));
  if (choices.length) show(choices[0].value);
}

export function rgb_of(cloud, vehicles, by) {
  if (by !== 'vehicle') return cloud.palette;
  const hex = (colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
  return vehicles.length ? vehicles.map((v) => hex(v.colour)) : [[120, 120, 120]];
}

function bits(mask) {
  let n = 0;
  for (let m = mask; m; m &= m - 1) ++n;
  return n;
}

/**
 * Points within a window, seen along one axis: what fills many slices of the depth (walls) is dark,
 * what lies flat (floors) is faint.
 * @param view axes [right, up, depth], window {x0, x1, y0, y1}, width, height, size of a point in pixels
 */
export function picture_of(cloud, rgb, by, view) {
  const {width, height, axes: [a, b, c], window: w, size} = view;
  const slices = new Uint32Array(width * height);
  const level = new Uint8Array(width * height);
  const level_of = cloud.level[by];
  const p = cloud.positions;
  const m = cloud.centre_m;
  const [low, depth] = [cloud.low_m[c] - m[c], Math.max(cloud.high_m[c] - cloud.low_m[c], 0.1)];
  const [sx, sy] = [width / (w.x1 - w.x0), height / (w.y1 - w.y0)];
  for (let i = 0; i < cloud.count; ++i) {
    const x = Math.floor((p[3 * i + a] + m[a] - w.x0) * sx);
    const y = Math.floor((w.y1 - p[3 * i + b] - m[b]) * sy);
    if (x < 0 || y < 0 || x >= width || y >= height) continue;
    const slice = Math.floor(((p[3 * i + c] - low) / depth) * SLICES);
    const bit = 1 << Math.min(Math.max(slice, 0), SLICES - 1);
    for (let dy = 0; dy < size && y + dy < height; ++dy) {
      for (let dx = 0; dx < size && x + dx < width; ++dx) {
        const at = (y + dy) * width + x + dx;
        slices[at] |= bit;
        level[at] = level_of[i];
      }
    }
  }
  return painted(slices, level, rgb, width, height);
}

/** Slices that nine of ten filled pixels stay below have the full colour. */
function many_slices(slices) {
  const count = new Uint32Array(SLICES + 1);
  let filled = 0;
  for (const mask of slices) {
    if (mask) { ++count[bits(mask)]; ++filled; }
  }
  let below = 0;
  for (let n = 1; n <= SLICES; ++n) {
    below += count[n];
    if (below >= 0.9 * filled) return Math.max(n, 2);
  }
  return 2;
}

function painted(slices, level, rgb, width, height) {
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [width, height];
  const ctx = canvas.getContext('2d');
  const image = ctx.createImageData(width, height);
  const most = many_slices(slices);
  for (let i = 0; i < slices.length; ++i) {
    if (!slices[i]) continue;
    const alpha = WEAKEST + (1 - WEAKEST) * Math.min((bits(slices[i]) - 1) / (most - 1), 1);
    const colour = rgb[level[i] % rgb.length];
    for (let n = 0; n < 3; ++n) image.data[4 * i + n] = colour[n];
    image.data[4 * i + 3] = 255 * alpha;
  }
  ctx.putImageData(image, 0, 0);
  return canvas;
}
