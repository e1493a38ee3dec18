// The page's one block of numbers: JSON, arrays as base64 of little-endian values.

function bytes_of(text) {
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
}

function float32_of(text) {
  return new Float32Array(bytes_of(text).buffer);
}

const TEXT = new Set(['name', 'group', 'colour', 'dash']);

/** Columns become arrays with null where nothing is known; `dash` a list of pixels. */
function unpack_vehicle(packed) {
  const v = {...packed, dash: packed.dash ? packed.dash.split(' ').map(Number) : []};
  for (const [key, value] of Object.entries(packed)) {
    if (TEXT.has(key) || typeof value !== 'string') continue;
    v[key] = key === 'state' ? bytes_of(value)
      : Array.from(float32_of(value), (x) => (Number.isFinite(x) ? x : null));
  }
  return v;
}

/** Positions in metres around `centre_m`. */
function unpack_cloud(packed) {
  const steps = new Int16Array(bytes_of(packed.points).buffer);
  const level = {};
  for (const by of ['height', 'sigma', 'vehicle']) level[by] = bytes_of(packed[by]);
  return {...packed, positions: Float32Array.from(steps, (n) => n * packed.step_m), level};
}

export function read_page() {
  const holder = document.getElementById('page-data');
  if (!holder) return null;
  const data = JSON.parse(holder.textContent);
  data.vehicles = data.vehicles.map(unpack_vehicle);
  if (data.cloud) data.cloud = unpack_cloud(data.cloud);
  for (const pair of data.pairs ?? []) {
    for (const s of pair.series) [s.t, s.residual] = [float32_of(s.t), float32_of(s.residual)];
  }
  return data;
}

/** The row of a vehicle nearest to a time. */
export function row_at(vehicle, t_s) {
  let [low, high] = [0, vehicle.rows - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (vehicle.t[middle] <= t_s) low = middle;
    else high = middle;
  }
  return t_s - vehicle.t[low] <= vehicle.t[high] - t_s ? low : high;
}

// Fields of a row's state; HeldBy and Sight count from good to bad.
export const UNKNOWN = 255;
export const held_by = (state) => state & 3;
export const sight = (state) => (state >> 2) & 3;
export const is_degenerate = (state) => state !== UNKNOWN && (state & 16) !== 0;
export const stands = (state) => state !== UNKNOWN && (state & 32) !== 0;

/** [first row, last row, value] of each stretch of rows with one value; null is no stretch. A hole
 *  in the times ends a stretch. */
export function stretches_of(vehicle, value_of) {
  const list = [];
  const step = vehicle.rows > 1 ? (vehicle.t[vehicle.rows - 1] - vehicle.t[0]) / vehicle.rows : 0;
  const hole_s = Math.max(1, 3 * step);
  for (let k = 0; k < vehicle.rows; ++k) {
    const value = value_of(vehicle.state[k]);
    const last = list[list.length - 1];
    const joins = last && last[1] === k - 1 && vehicle.t[k] - vehicle.t[k - 1] <= hole_s;
    if (joins) last[1] = k;  // a state holds until the next row
    if (joins && last[2] === value) continue;
    if (value !== null) list.push([k, k, value]);
  }
  return list;
}
