// read_mcap.mjs MODULES SESSION.mcap TOPIC...: reads every record with @mcap/core and decodes every
// message with Foxglove's ROS 2 packages, by the schemas in the file itself. Each TOPIC must be there.
// Exit 77: the packages are not there.
import {createRequire} from 'node:module';
import {readFileSync} from 'node:fs';

const [modules, path, ...wanted] = process.argv.slice(2);
const load = createRequire(modules + '/package.json');
let mcap, rosmsg, serialization, zstd, lz4;
try {
  mcap = load('@mcap/core');
  rosmsg = load('@foxglove/rosmsg');
  serialization = load('@foxglove/rosmsg2-serialization');
  zstd = load('fzstd');
  lz4 = load('lz4js');
} catch (error) {
  console.log(`SKIPPED: ${error.message.split('\n')[0]}; tools/conformance.sh fetches the packages`);
  process.exit(77);
}

const data = readFileSync(path);
const readable = {
  size: async () => BigInt(data.length),
  read: async (offset, size) => new Uint8Array(data.subarray(Number(offset), Number(offset + size))),
};
const decompressHandlers = {
  zstd: (bytes, size) => zstd.decompress(bytes, new Uint8Array(Number(size))),
  lz4: (bytes) => lz4.decompress(bytes),
};

/** Every number of a decoded message; what is not finite is counted, not refused. */
function* numbers(value) {
  if (typeof value === 'number') yield value;
  else if (ArrayBuffer.isView(value)) return;
  else if (value && typeof value === 'object') for (const inner of Object.values(value)) yield* numbers(inner);
}

const reader = await mcap.McapIndexedReader.Initialize({readable, decompressHandlers});
const decoders = new Map();
const topics = new Map();
let notFinite = 0;
let last = -1n;
for await (const message of reader.readMessages({validateCrcs: true})) {
  const channel = reader.channelsById.get(message.channelId);
  const schema = reader.schemasById.get(channel.schemaId);
  if (channel.messageEncoding !== 'cdr' || schema.encoding !== 'ros2msg') {
    throw new Error(`${channel.topic}: ${channel.messageEncoding}, ${schema.encoding}: not ROS 2`);
  }
  if (!decoders.has(schema.id)) {
    const text = new TextDecoder().decode(schema.data);
    decoders.set(schema.id, new serialization.MessageReader(rosmsg.parse(text, {ros2: true})));
  }
  const decoded = decoders.get(schema.id).readMessage(message.data);
  for (const number of numbers(decoded)) if (!Number.isFinite(number)) notFinite += 1;
  if (message.logTime < last) throw new Error(`${channel.topic}: out of log time order`);
  last = message.logTime;
  const seen = topics.get(channel.topic) ?? {count: 0, type: schema.name};
  topics.set(channel.topic, {...seen, count: seen.count + 1});
}
const stated = Number(reader.statistics.messageCount);
let read = 0;
for (const [topic, {count, type}] of [...topics].sort()) {
  console.log(`${topic} ${type}: ${count} messages`);
  read += count;
}
console.log(`${notFinite} numbers not finite`);
if (read !== stated) throw new Error(`${read} messages read, the statistics state ${stated}`);
for (const topic of wanted) if (!topics.has(topic)) throw new Error(`no message on ${topic}`);
