// Messages of ROS 2 in CDR (XCDR1): only what the page shows. A damaged message throws; the caller drops it.

/** Reads one message; alignment counts from behind the four bytes of the encapsulation. */
class Reader {
  constructor(view) {
    this.view = view;
    this.little = view.getUint8(1) === 1;
    this.at = 4;
  }

  align(n) {
    this.at += (n - ((this.at - 4) % n)) % n;
  }

  number(size, get) {
    this.align(size);
    const value = this.view[get](this.at, this.little);
    this.at += size;
    return value;
  }

  u8() { return this.view.getUint8(this.at++); }
  u32() { return this.number(4, 'getUint32'); }
  i32() { return this.number(4, 'getInt32'); }
  f32() { return this.number(4, 'getFloat32'); }
  f64() { return this.number(8, 'getFloat64'); }

  /** The bytes of a sequence or string, not copied. */
  bytes(count) {
    if (count > this.view.byteLength - this.at) throw new RangeError('a sequence is longer than its message');
    const out = new Uint8Array(this.view.buffer, this.view.byteOffset + this.at, count);
    this.at += count;
    return out;
  }

  text() {
    const bytes = this.bytes(this.u32());
    return new TextDecoder().decode(bytes.subarray(0, Math.max(bytes.length - 1, 0)));
  }

  header() {
    const stamp_s = this.i32() + 1e-9 * this.u32();
    return {stamp_s, frame: this.text()};
  }
}

const FLOAT32 = 7;
const UINT8 = 2;
const UINT32 = 6;

function fields_of(reader) {
  const count = reader.u32();
  if (count > 64) throw new RangeError('a cloud with more than 64 fields');
  const fields = new Map();
  for (let i = 0; i < count; ++i) {
    const name = reader.text();
    const offset = reader.u32();
    const type = reader.u8();
    reader.u32();
    fields.set(name, {offset, type});
  }
  return fields;
}

/** Columns of a PointCloud2: {stamp_s, count, positions, keyframe?, vehicle?, age_s?}; no more than `max` points. */
export function decode_cloud(view, max) {
  const reader = new Reader(view);
  const {stamp_s, frame} = reader.header();
  const height = reader.u32();
  const width = reader.u32();
  const fields = fields_of(reader);
  const little = reader.u8() === 0;
  const step = reader.u32();
  const row = reader.u32();
  const data = reader.bytes(reader.u32());
  const bytes = new DataView(data.buffer, data.byteOffset, data.byteLength);
  if (step === 0 || (height > 1 && row !== step * width)) throw new RangeError('a cloud with gaps between rows');
  const count = Math.min(width * height, Math.floor(data.byteLength / step), max);
  const column = (name, type, size, array, get) => {
    const field = fields.get(name);
    if (field?.type !== type || field.offset + size > step) return null;
    const out = new array(count);
    for (let i = 0; i < count; ++i) out[i] = bytes[get](i * step + field.offset, little);
    return out;
  };
  const axes = ['x', 'y', 'z'].map((name) => column(name, FLOAT32, 4, Float32Array, 'getFloat32'));
  if (axes.includes(null)) throw new RangeError('a cloud without x, y, z as float32');
  const positions = new Float32Array(3 * count);
  for (let i = 0; i < count; ++i) for (let n = 0; n < 3; ++n) positions[3 * i + n] = axes[n][i];
  return {
    stamp_s, frame, count, positions,
    keyframe: column('keyframe', UINT32, 4, Uint32Array, 'getUint32'),
    vehicle: column('vehicle', UINT8, 1, Uint8Array, 'getUint8'),
    age_s: column('age_s', FLOAT32, 4, Float32Array, 'getFloat32'),
  };
}

/** An OccupancyGrid: {width, height, resolution_m, x_m, y_m, yaw_rad, cells}. */
export function decode_grid(view) {
  const reader = new Reader(view);
  reader.header();
  reader.i32();
  reader.u32();
  const resolution_m = reader.f32();
  const width = reader.u32();
  const height = reader.u32();
  const [x_m, y_m] = [reader.f64(), reader.f64()];
  reader.f64();
  const [qx, qy, qz, qw] = [reader.f64(), reader.f64(), reader.f64(), reader.f64()];
  const cells = reader.bytes(reader.u32());
  if (width * height !== cells.length || width * height > 16e6) throw new RangeError('a grid of another size');
  return {
    width, height, resolution_m, x_m, y_m, cells,
    yaw_rad: Math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)),
  };
}
