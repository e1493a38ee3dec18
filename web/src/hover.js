// Values under the pointer, read back from the drawn paths: the numbers are not in the page twice.

/** Points [x, y] of a path of absolute M and L commands, in pixels; "h0" ends a dot, its shape follows. */
export function path_points(d) {
  const points = [];
  for (const part of d.split(/[ML]/)) {
    const numbers = part.split('h0')[0].trim().split(/[ ,]+/).map(Number);
    if (numbers.length === 2 && numbers.every(Number.isFinite)) points.push(numbers);
  }
  return points;
}

/** The point nearest to (x, y); in a plot over time only x counts. */
export function nearest(points, x, y, both) {
  let best = null;
  let least = Infinity;
  for (const p of points) {
    const distance = both ? Math.hypot(p[0] - x, p[1] - y) : Math.abs(p[0] - x);
    if (distance < least) [least, best] = [distance, p];
  }
  return best && {point: best, distance: least};
}

/** Four digits that mean something. */
export function short_number(value) {
  if (!Number.isFinite(value)) return '-';
  const size = Math.abs(value);
  if (size !== 0 && size < 1e-3) return value.toExponential(2);
  return value.toFixed(size >= 100 ? 1 : size >= 1 ? 2 : 4);
}

const box = document.createElement('div');
box.className = 'values';

function pixel_of(plot, event) {
  const matrix = plot.getScreenCTM();
  return matrix ? new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse()) : null;
}

function value_of(pixel, low, high, from, to) {
  return from + ((pixel - low) / (high - low)) * (to - from);
}

function line_of(series, hit, scale) {
  const x = value_of(hit.point[0], scale.l, scale.r, scale.x0, scale.x1);
  let y = value_of(hit.point[1], scale.b, scale.t, scale.y0, scale.y1);
  if (scale.log) y = 10 ** y;
  const at = scale.both
    ? `x ${short_number(x)} m, ${scale.yn ?? 'y'} ${short_number(y)} m`
    : `${short_number(y)} ${scale.yu ?? ''} at ${short_number(x)} ${scale.xu ?? ''}`;
  return `${series.label}: ${at}`;
}

/** Shows the nearest value of each series of a plot while the pointer is over it. */
export function show_values(plot) {
  const scale = JSON.parse(plot.dataset.scale);
  let all = null;
  const read = () => [...plot.querySelectorAll('path.s')].map((path) => (
    {label: path.dataset.label ?? '', points: path_points(path.getAttribute('d') ?? '')}));

  plot.addEventListener('pointermove', (event) => {
    all ??= read();
    const at = pixel_of(plot, event);
    if (!at) return;
    let hits = [];
    for (const series of all) {
      const hit = nearest(series.points, at.x, at.y, scale.both);
      if (hit && hit.distance < 25) hits.push({series, hit});
    }
    if (scale.both) hits = hits.sort((a, b) => a.hit.distance - b.hit.distance).slice(0, 1);
    // A series drawn in pieces shows its nearest piece once.
    const seen = new Set();
    hits = hits.sort((a, b) => a.hit.distance - b.hit.distance)
      .filter(({series}) => !seen.has(series.label) && seen.add(series.label));
    box.replaceChildren(...hits.map(({series, hit}) => {
      const line = document.createElement('div');
      line.textContent = line_of(series, hit, scale);
      return line;
    }));
    box.style.left = `${event.pageX + 14}px`;
    box.style.top = `${event.pageY + 14}px`;
    if (hits.length) document.body.append(box);
    else box.remove();
  });
  plot.addEventListener('pointerleave', () => box.remove());
}
