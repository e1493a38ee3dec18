// Arrays of numbers out of the page: base64 of little-endian values.

function bytes_of(text) {
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
}

/** Positions in metres of points packed as int16 x y z in steps of `step`. */
export function positions_of(text, step) {
  const view = new DataView(bytes_of(text).buffer);
  const out = new Float32Array(view.byteLength / 2);
  for (let i = 0; i < out.length; ++i) out[i] = view.getInt16(2 * i, true) * step;
  return out;
}

export function float32_of(text) {
  const view = new DataView(bytes_of(text).buffer);
  const out = new Float32Array(view.byteLength / 4);
  for (let i = 0; i < out.length; ++i) out[i] = view.getFloat32(4 * i, true);
  return out;
}

export {bytes_of as uint8_of};
