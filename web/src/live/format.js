// Numbers as text. What is not known is a dash.

export const DASH = '–';

export const number = (value, digits, unit) =>
  (Number.isFinite(value) ? `${value.toFixed(digits)}${unit ? ` ${unit}` : ''}` : DASH);

export const metres = (value) => number(value, Math.abs(value) < 10 ? 2 : 1, 'm');

export function percent(fraction) {
  if (!Number.isFinite(fraction)) return DASH;
  const value = 100 * fraction;
  return `${value < 10 && value > 0 ? value.toFixed(1) : value.toFixed(0)} %`;
}

export function bytes(value) {
  if (!Number.isFinite(value)) return DASH;
  const units = ['B', 'kB', 'MB', 'GB', 'TB'];
  let n = 0;
  while (value >= 1000 && n < units.length - 1) { value /= 1000; ++n; }
  return `${value.toFixed(n && value < 10 ? 1 : 0)} ${units[n]}`;
}

export const rate = (value) => (Number.isFinite(value) ? `${bytes(value)}/s` : DASH);

export const milliseconds = (value) => number(1e3 * value, value < 0.01 ? 1 : 0, 'ms');

export function ago(value) {
  if (!Number.isFinite(value)) return DASH;
  if (value < 10) return `${value.toFixed(1)} s`;
  if (value < 120) return `${value.toFixed(0)} s`;
  return `${(value / 60).toFixed(0)} min`;
}

/** 3723 becomes 1:02:03. */
export function clock(value) {
  const s = Math.max(0, Math.floor(value));
  const two = (n) => String(n).padStart(2, '0');
  const minutes = Math.floor(s / 60);
  return minutes < 60 ? `${minutes}:${two(s % 60)}` : `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${two(s % 60)}`;
}
