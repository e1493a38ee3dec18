// Links of a pair.

/** Both directions of a pair as one: the worse loss, the lower rate. */
export function worst_links(links) {
  const pairs = new Map();
  for (const link of links) {
    const key = [link.from, link.to].sort().join('\n');
    const before = pairs.get(key);
    if (!before) pairs.set(key, {...link});
    else {
      before.connected = before.connected && link.connected;
      before.loss = worse(Math.max, before.loss, link.loss);
      before.rate_Bps = worse(Math.min, before.rate_Bps, link.rate_Bps);
    }
  }
  return [...pairs.values()];
}

function worse(choose, a, b) {
  if (a === undefined || b === undefined) return a ?? b;
  return choose(a, b);
}
