// Where vehicles are at the time under the cursor: plots send it, maps show it.
const listeners = [];

/** @param listener called with vehicles and a time; null: the cursor left */
export function on_time(listener) {
  listeners.push(listener);
}

export function show_time(vehicles, t_s) {
  for (const listener of listeners) listener(vehicles ?? [], t_s);
}
