#include "rali/io/containers/mcap_format.hpp"

namespace rali::io {

std::optional<McapRecord> read_mcap_record(Cursor& cursor) {
  const auto op = static_cast<McapOp>(cursor.u8());
  const std::uint64_t length = cursor.u64();
  const auto content = cursor.bytes(length);
  if (!cursor.ok()) return std::nullopt;
  return McapRecord{op, content};
}

std::optional<McapSchema> mcap_schema(std::span<const std::byte> content) {
  Cursor cursor(content);
  McapSchema schema;
  schema.id = cursor.u16();
  schema.name = cursor.text32();
  schema.encoding = cursor.text32();
  schema.data = cursor.text32();
  if (!cursor.ok()) return std::nullopt;
  return schema;
}

std::optional<McapChannel> mcap_channel(std::span<const std::byte> content) {
  Cursor cursor(content);
  McapChannel channel;
  channel.id = cursor.u16();
  channel.schema = cursor.u16();
  channel.topic = cursor.text32();
  channel.encoding = cursor.text32();
  if (!cursor.ok()) return std::nullopt;
  return channel;
}

std::optional<McapMessageHeader> mcap_message(std::span<const std::byte> content) {
  Cursor cursor(content);
  McapMessageHeader message;
  message.channel = cursor.u16();
  message.sequence = cursor.u32();
  message.log_ns = cursor.u64();
  message.publish_ns = cursor.u64();
  if (!cursor.ok()) return std::nullopt;
  return message;
}

std::optional<McapChunkHeader> mcap_chunk(std::span<const std::byte> content) {
  Cursor cursor(content);
  McapChunkHeader chunk;
  cursor.u64();  // start and end time: taken from the messages
  cursor.u64();
  chunk.uncompressed_bytes = cursor.u64();
  chunk.uncompressed_crc = cursor.u32();
  chunk.compression = cursor.text32();
  chunk.record_bytes = cursor.u64();
  chunk.header_bytes = cursor.at();
  if (!cursor.ok()) return std::nullopt;
  return chunk;
}

std::optional<McapChunkIndex> mcap_chunk_index(std::span<const std::byte> content) {
  Cursor cursor(content);
  McapChunkIndex index;
  index.first_ns = cursor.u64();
  index.last_ns = cursor.u64();
  index.offset = cursor.u64();
  if (!cursor.ok()) return std::nullopt;
  return index;
}

std::optional<McapStatistics> mcap_statistics(std::span<const std::byte> content) {
  Cursor cursor(content);
  McapStatistics statistics;
  statistics.messages = cursor.u64();
  cursor.u16();  // schemas
  statistics.channels = cursor.u32();
  cursor.u32();  // attachments
  cursor.u32();  // metadata
  statistics.chunks = cursor.u32();
  statistics.first_ns = cursor.u64();
  statistics.last_ns = cursor.u64();
  Cursor counts(cursor.bytes32());
  while (counts.left() > 0) {
    const std::uint16_t channel = counts.u16();
    statistics.counts.emplace_back(channel, counts.u64());
  }
  if (!cursor.ok() || !counts.ok()) return std::nullopt;
  return statistics;
}

}  // namespace rali::io
