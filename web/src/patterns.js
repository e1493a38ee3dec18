// Fills that differ on grey paper too: what the LiDAR observes, what held a vehicle, roles.
const FILLS = {
  good: ['#dfe5ec'], by_range: ['#31465e'], used: ['#31465e'], drives: ['#dfe6ee'], stands: ['#9fb0c3'], anchor: ['#31465e'],
  partial: ['#f4ead2', '#7a5c14', 'dots'], degenerate: ['#ffffff', '#d55e00', 'slant'],
  by_imu: ['#ffffff', '#5b7fa6', 'upright'], by_nothing: ['#c0161d', '#ffffff', 'crossed'],
  rejected: ['#ffffff', '#962200', 'upright'], shade: ['#d55e000d', '#d55e0073', 'thin'],
};

const LINES = {
  dots: [[4, 4, 5, 4]], upright: [[2, 0, 2, 12], [8, 0, 8, 12]], crossed: [[0, 0, 12, 12], [12, 0, 0, 12]],
  slant: [[-3, 9, 9, -3], [3, 15, 15, 3]], thin: [[-3, 15, 15, -3]],
};
const WIDTHS = {dots: 2.5, upright: 2.5, crossed: 1.5, slant: 5, thin: 1.2};

function tile_of(kind) {
  const [ground, line, form] = FILLS[kind];
  const tile = document.createElement('canvas');
  tile.width = tile.height = 12;
  const ctx = tile.getContext('2d');
  ctx.fillStyle = ground;
  ctx.fillRect(0, 0, 12, 12);
  ctx.strokeStyle = line;
  ctx.lineWidth = WIDTHS[form];
  for (const [a, b, c, d] of LINES[form]) {
    ctx.beginPath();
    ctx.moveTo(a, b);
    ctx.lineTo(c, d);
    ctx.stroke();
  }
  return tile;
}

const made = new Map();

/** A fillStyle. */
export function pattern_of(ctx, kind) {
  if (!FILLS[kind][1]) return FILLS[kind][0];
  if (!made.has(kind)) made.set(kind, tile_of(kind));
  return ctx.createPattern(made.get(kind), 'repeat');
}

/** Fills the keys of a legend that the page holds: <i data-kind="by_range">. */
export function fill_keys() {
  for (const key of document.querySelectorAll('i[data-kind]')) {
    const fill = FILLS[key.dataset.kind];
    if (fill) key.style.background = fill[1] ? `url(${tile_of(key.dataset.kind).toDataURL()})` : fill[0];
  }
}
