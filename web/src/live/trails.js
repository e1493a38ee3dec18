// Where a vehicle has driven until a moment: by the newest table, then as it was seen since.

const STEP_M = 0.3;

export function trail_at(name, t_s, paths, history) {
  const points = [];
  const degenerate = [];
  const path = paths?.find((p) => p.vehicle === name);
  let from_s = -Infinity;
  if (path) {
    for (let i = 0; i < path.position_m.length && path.t_s[i] <= t_s; ++i) {
      points.push(path.position_m[i]);
      degenerate.push(path.degenerate?.[i] ?? 0);
      from_s = path.t_s[i];
    }
    // Later states are of no use where the path itself goes on.
    if (path.t_s.at(-1) > t_s) return {points, degenerate};
  }
  for (let i = Math.max(history.index_at(from_s), 0); i < history.states.length; ++i) {
    const state = history.states[i];
    if (state.t_s > t_s) break;
    if (state.t_s <= from_s) continue;
    const v = state.vehicles?.find((one) => one.name === name);
    if (!v?.position_m || v.frame === 'local') continue;
    const last = points.at(-1);
    if (last && Math.hypot(v.position_m[0] - last[0], v.position_m[1] - last[1], v.position_m[2] - last[2]) < STEP_M) continue;
    points.push(v.position_m);
    degenerate.push(v.degenerate ? 1 : 0);
  }
  return {points, degenerate};
}
