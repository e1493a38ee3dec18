// The Foxglove WebSocket as the page uses it: subscribes to what it shows, comes back after a cut.

const SUBPROTOCOL = 'foxglove.websocket.v1';
const WANTED = [/^\/rali\/(state|paths|history)$/, /^\/map$/, /^\/map_cloud$/, /^\/[^/]+\/map_delta$/];
const AGAIN_MS = 1500;
const ALIVE_MS = 5000;

/**
 * @param on {open(), closed(), message(topic, t_s, DataView)}
 */
export function connect(on) {
  const scheme = location.protocol === 'https:' ? 'wss:' : 'ws:';
  const url = `${scheme}//${location.host}/ws${location.search}`;
  let alive = 0;
  const start = () => {
    const socket = new WebSocket(url, [SUBPROTOCOL]);
    socket.binaryType = 'arraybuffer';
    const topics = new Map();  // by subscription, which has the number of its channel
    socket.onopen = () => {
      // Behind a large frame no ping is answered in time; any message shows that the page lives.
      alive = setInterval(() => socket.send('{"op":"subscribe","subscriptions":[]}'), ALIVE_MS);
      on.open();
    };
    socket.onclose = () => {
      clearInterval(alive);
      on.closed();
      setTimeout(start, AGAIN_MS);
    };
    socket.onmessage = ({data}) => {
      if (typeof data === 'string') subscribe(socket, topics, JSON.parse(data));
      else take(data, topics, on);
    };
  };
  start();
}

function subscribe(socket, topics, message) {
  if (message.op === 'status' && message.level > 0) console.warn(message.message);
  if (message.op !== 'advertise') return;
  const subscriptions = [];
  for (const {id, topic} of message.channels) {
    if (!WANTED.some((pattern) => pattern.test(topic))) continue;
    topics.set(id, topic);
    subscriptions.push({id, channelId: id});
  }
  if (subscriptions.length) socket.send(JSON.stringify({op: 'subscribe', subscriptions}));
}

function take(data, topics, on) {
  const view = new DataView(data);
  if (view.byteLength < 13 || view.getUint8(0) !== 1) return;
  const topic = topics.get(view.getUint32(1, true));
  if (topic) on.message(topic, Number(view.getBigUint64(5, true)) * 1e-9, new DataView(data, 13));
}
