// The points of the map on the graphics card. Each knows when it was first seen: the timeline only moves a number.
import {BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, GLSL3, Points, ShaderMaterial} from 'three';
import {HEIGHTS, vehicle_colour} from './colours.js';

export const POINTS_MAX = 1e6;
const NEVER_S = 3e38;
const VEHICLES = 8;
const ODD = 0.004;  // so many points on each side do not decide what is shown

const VERTEX = `
  in float seen_s;
  in float vehicle;
  uniform float now_s, size, scale, low_m, high_m, cut_m, fresh_s;
  uniform int by;
  uniform vec3 heights[5];
  uniform vec3 vehicles[${VEHICLES}];
  out vec3 colour;
  void main() {
    vec4 p = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * p;
    gl_PointSize = clamp(size * scale / max(-p.z, 0.1), 1.3, 5.0);
    if (seen_s > now_s || position.z > cut_m) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    float h = clamp((position.z - low_m) / max(high_m - low_m, 0.1), 0.0, 0.999) * 4.0;
    int n = int(h);
    colour = by == 1 ? vehicles[int(vehicle) % ${VEHICLES}] : mix(heights[n], heights[n + 1], h - float(n));
    float fresh = clamp(1.0 - (now_s - seen_s) / fresh_s, 0.0, 1.0);
    colour = mix(colour, vec3(1.0), 0.55 * fresh);
  }`;

const FRAGMENT = `
  precision mediump float;
  in vec3 colour;
  uniform float alpha;
  out vec4 pixel;
  void main() { pixel = vec4(colour, alpha); }`;

function make_material() {
  const rgb = (hex) => new Color(hex);
  return new ShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: {
      now_s: {value: 0}, size: {value: 0.12}, scale: {value: 800}, low_m: {value: 0}, high_m: {value: 3},
      cut_m: {value: 1e9}, fresh_s: {value: 6}, by: {value: 0}, alpha: {value: 1},
      heights: {value: HEIGHTS.map(rgb)},
      vehicles: {value: Array.from({length: VEHICLES}, (_, i) => rgb(vehicle_colour(i)))},
    },
  });
}

export class PointStore {
  constructor() {
    this.points = new Points(new BufferGeometry(), make_material());
    this.points.frustumCulled = false;
    this.count = 0;
    this.keyframes = new Map();  // 'vehicle keyframe': [[start, end], ...]
    this.allocate(1 << 16);
    this.reset_heights();
  }

  reset_heights() {
    this.height_bins = new Uint32Array(400);  // 0.25 m each, from -50 m
  }

  allocate(capacity) {
    const grown = (old, size, array) => {
      const values = new array(capacity * size);
      if (old) values.set(old.array.subarray(0, this.count * size));
      const attribute = new BufferAttribute(values, size);
      attribute.setUsage(DynamicDrawUsage);
      return attribute;
    };
    const old = this.points.geometry;
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', grown(old.attributes.position, 3, Float32Array));
    geometry.setAttribute('seen_s', grown(old.attributes.seen_s, 1, Float32Array));
    geometry.setAttribute('vehicle', grown(old.attributes.vehicle, 1, Float32Array));
    old.dispose();
    this.points.geometry = geometry;
    this.capacity = capacity;
  }

  /** Times of points are seconds since the first state: a float has no room for a clock. */
  set_start(start_s) {
    this.start_s ??= start_s;
  }

  clear() {
    this.count = 0;
    this.keyframes.clear();
    this.reset_heights();
  }

  /** Adds a cloud; `whole`: in place of all points. */
  add(cloud, vehicle, whole) {
    if (whole) this.clear();
    if (cloud.keyframe) this.forget(cloud, vehicle);
    const n = Math.min(cloud.count, POINTS_MAX - this.count);
    if (this.count + n > this.capacity) {
      this.allocate(Math.min(Math.max(2 * this.capacity, this.count + n), POINTS_MAX));
    }
    const {position, seen_s, vehicle: owner} = this.points.geometry.attributes;
    const stamp_s = cloud.stamp_s - (this.start_s ?? 0);
    for (let i = 0; i < n; ++i) {
      const at = this.count + i;
      // A whole map without ages has always been there.
      seen_s.array[at] = cloud.age_s ? stamp_s - cloud.age_s[i] : whole ? -1e6 : stamp_s;
      owner.array[at] = cloud.vehicle ? cloud.vehicle[i] : vehicle;
      if (Number.isFinite(cloud.positions[3 * i] + cloud.positions[3 * i + 1] + cloud.positions[3 * i + 2])) continue;
      seen_s.array[at] = NEVER_S;
      cloud.positions.fill(0, 3 * i, 3 * i + 3);
    }
    position.array.set(cloud.positions.subarray(0, 3 * n), 3 * this.count);
    this.count_heights(cloud.positions, n);
    for (const attribute of [position, seen_s, owner]) {
      const size = attribute.itemSize;
      if (!whole) attribute.addUpdateRange(this.count * size, n * size);
      attribute.needsUpdate = true;
    }
    if (cloud.keyframe) this.remember(cloud, vehicle, n);
    this.count += n;
    this.points.geometry.setDrawRange(0, this.count);
  }

  remember(cloud, vehicle, n) {
    for (let i = 0; i < n;) {
      let end = i + 1;
      while (end < n && cloud.keyframe[end] === cloud.keyframe[i]) ++end;
      const key = `${vehicle} ${cloud.keyframe[i]}`;
      const runs = this.keyframes.get(key) ?? [];
      runs.push([this.count + i, this.count + end]);
      this.keyframes.set(key, runs);
      i = end;
    }
  }

  /** Points of keyframes that come again vanish. */
  forget(cloud, vehicle) {
    const {seen_s} = this.points.geometry.attributes;
    for (const keyframe of new Set(cloud.keyframe)) {
      const key = `${vehicle} ${keyframe}`;
      for (const [start, end] of this.keyframes.get(key) ?? []) {
        seen_s.array.fill(NEVER_S, start, end);
        seen_s.addUpdateRange(start, end - start);
      }
      this.keyframes.delete(key);
    }
    seen_s.needsUpdate = true;
  }

  count_heights(positions, n) {
    for (let i = 2; i < 3 * n; i += 3) ++this.height_bins[Math.min(Math.max(Math.floor((positions[i] + 50) * 4), 0), 399)];
    const {uniforms} = this.points.material;
    uniforms.low_m.value = this.height_at(0.03, this.count + n);
    uniforms.high_m.value = this.height_at(0.97, this.count + n);
  }

  /** Positions of about `count` points that are seen, one list; what lies far out by itself is left out. */
  sample(count) {
    const {position, seen_s} = this.points.geometry.attributes;
    const out = [];
    const step = Math.max(Math.ceil(this.count / count), 1);
    for (let i = 0; i < this.count; i += step) {
      if (seen_s.array[i] < 0.5 * NEVER_S) out.push([0, 1, 2].map((k) => position.array[3 * i + k]));
    }
    const low = [];
    const high = [];
    for (let k = 0; k < 3; ++k) {
      const sorted = Float32Array.from(out, (p) => p[k]).sort();
      low.push(sorted[Math.floor(ODD * sorted.length)]);
      high.push(sorted[Math.ceil((1 - ODD) * sorted.length) - 1]);
    }
    return out.filter((p) => p.every((value, k) => value >= low[k] && value <= high[k])).flat();
  }

  /** Height below which this fraction of the points lies. */
  height_at(fraction, count) {
    let below = 0;
    const wanted = Math.max(fraction * count, 1);
    for (let i = 0; i < 400; ++i) {
      below += this.height_bins[i];
      if (below >= wanted) return i / 4 - 50;
    }
    return 0;
  }
}
