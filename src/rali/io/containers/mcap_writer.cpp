#include "rali/io/containers/mcap_writer.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "rali/io/containers/crc32.hpp"
#include "rali/io/containers/mcap_format.hpp"

namespace rali::io {
namespace {

constexpr std::string_view kLibrary = "rali";

void append_record(McapOp op, std::span<const std::byte> content, std::vector<std::byte>& out) {
  Appender append(out);
  append.u8(static_cast<std::uint8_t>(op));
  append.u64(content.size());
  append.bytes(content);
}

/// In MCAP the empty string means no compression.
std::string_view mcap_name(Compression compression) {
  return compression == Compression::kNone ? std::string_view() : name_of(compression);
}

}  // namespace

Status McapWriter::put(std::span<const std::byte> bytes) {
  written_ += bytes.size();
  return sink_.write(bytes);
}

Status McapWriter::begin() {
  if (closed_) return fail(ErrorCode::kUsage, "mcap", "written to after it was closed");
  if (written_ > 0) return {};
  if (options_.compression == Compression::kBz2) {
    return fail(ErrorCode::kUsage, "mcap", "bz2 is not a compression of MCAP");
  }
  std::vector<std::byte> content;
  Appender(content).text32(options_.profile);
  Appender(content).text32(kLibrary);
  std::vector<std::byte> out;
  Appender(out).text(kMcapMagic);
  append_record(McapOp::kHeader, content, out);
  return put(out);
}

Result<std::uint16_t> McapWriter::add_schema(const std::string& name, const std::string& encoding,
                                             const std::string& definition) {
  if (schemas_.size() >= std::numeric_limits<std::uint16_t>::max()) {
    return fail(ErrorCode::kUsage, "mcap", "more than 65535 schemas");
  }
  // Number 0 means "none", so the first is 1.
  const auto number = static_cast<std::uint16_t>(schemas_.size() + 1);
  std::vector<std::byte> content;
  Appender append(content);
  append.u16(number);
  append.text32(name);
  append.text32(encoding);
  append.text32(definition);
  schemas_.emplace_back();
  append_record(McapOp::kSchema, content, schemas_.back().record);
  return number;
}

Result<std::uint16_t> McapWriter::add_channel(std::uint16_t schema, const std::string& topic,
                                              const std::string& message_encoding,
                                              const std::map<std::string, std::string>& metadata) {
  if (schema > schemas_.size()) {
    return fail(ErrorCode::kUsage, "mcap", fmt::format("no schema {}", schema));
  }
  if (channels_.size() > std::numeric_limits<std::uint16_t>::max()) {
    return fail(ErrorCode::kUsage, "mcap", "more than 65536 channels");
  }
  const auto number = static_cast<std::uint16_t>(channels_.size());
  std::vector<std::byte> pairs;
  for (const auto& [key, value] : metadata) {
    Appender(pairs).text32(key);
    Appender(pairs).text32(value);
  }
  std::vector<std::byte> content;
  Appender append(content);
  append.u16(number);
  append.u16(schema);
  append.text32(topic);
  append.text32(message_encoding);
  append.text32(text_of(pairs));
  channels_.emplace_back();
  channels_.back().schema = schema;
  append_record(McapOp::kChannel, content, channels_.back().record);
  return number;
}

/// Schema and channel go before the channel's first message.
void McapWriter::append_definitions(Channel& channel) {
  if (channel.in_file) return;
  channel.in_file = true;
  if (channel.schema != 0 && !schemas_[channel.schema - 1U].in_file) {
    schemas_[channel.schema - 1U].in_file = true;
    Appender(chunk_).bytes(schemas_[channel.schema - 1U].record);
  }
  Appender(chunk_).bytes(channel.record);
}

Status McapWriter::write(std::uint16_t channel, Time t_log, Time t_publish,
                         std::span<const std::byte> data) {
  if (const Status status = begin(); !status) return status;
  if (channel >= channels_.size()) {
    return fail(ErrorCode::kUsage, "mcap", fmt::format("no channel {}", channel));
  }
  if (t_log.ns < 0 || t_publish.ns < 0) {
    return fail(ErrorCode::kInput, "mcap", "time before 1970 does not fit an MCAP");
  }
  Channel& known = channels_[channel];
  const auto log_ns = static_cast<std::uint64_t>(t_log.ns);
  chunk_first_ns_ = chunk_entries_.empty() ? log_ns : std::min(chunk_first_ns_, log_ns);
  chunk_last_ns_ = chunk_entries_.empty() ? log_ns : std::max(chunk_last_ns_, log_ns);
  first_ns_ = messages_ == 0 ? log_ns : std::min(first_ns_, log_ns);
  last_ns_ = std::max(last_ns_, log_ns);
  append_definitions(known);
  chunk_entries_[channel].emplace_back(log_ns, chunk_.size());
  Appender append(chunk_);
  append.u8(static_cast<std::uint8_t>(McapOp::kMessage));
  append.u64(McapMessageHeader::kBytes + data.size());
  append.u16(channel);
  append.u32(known.sequence++);
  append.u64(log_ns);
  append.u64(static_cast<std::uint64_t>(t_publish.ns));
  append.bytes(data);
  ++known.messages;
  ++messages_;
  return chunk_.size() >= options_.chunk_bytes ? flush_chunk() : Status();
}

Status McapWriter::flush_chunk() {
  if (chunk_.empty()) return {};
  if (options_.chunk_bytes == 0) {
    const Status status = put(chunk_);
    chunk_.clear();
    chunk_entries_.clear();
    return status;
  }
  const auto packed = compress(options_.compression, chunk_);
  if (!packed) return tl::make_unexpected(packed.error());
  std::vector<std::byte> head;
  Appender content(head);
  content.u64(chunk_first_ns_);
  content.u64(chunk_last_ns_);
  content.u64(chunk_.size());
  content.u32(crc32(chunk_));
  content.text32(mcap_name(options_.compression));
  content.u64(packed->size());
  std::vector<std::byte> out;
  Appender append(out);
  append.u8(static_cast<std::uint8_t>(McapOp::kChunk));
  append.u64(head.size() + packed->size());
  append.bytes(head);
  append.bytes(*packed);
  ChunkIndex index{chunk_first_ns_, chunk_last_ns_, written_, out.size(), {}, 0,
                   packed->size(),  chunk_.size()};
  if (const Status status = put(out); !status) return status;
  if (const Status status = write_index(index); !status) return status;
  chunks_.push_back(std::move(index));
  chunk_.clear();
  chunk_entries_.clear();
  return {};
}

/// Message indexes, one per channel, right behind the chunk.
Status McapWriter::write_index(ChunkIndex& chunk) {
  std::vector<std::byte> out;
  for (const auto& [channel, entries] : chunk_entries_) {
    chunk.index_offsets[channel] = written_ + out.size();
    std::vector<std::byte> content;
    Appender append(content);
    append.u16(channel);
    append.u32(static_cast<std::uint32_t>(entries.size() * 16));
    for (const auto& [log_ns, offset] : entries) {
      append.u64(log_ns);
      append.u64(offset);
    }
    append_record(McapOp::kMessageIndex, content, out);
  }
  chunk.index_bytes = out.size();
  return put(out);
}

std::vector<std::byte> McapWriter::statistics() const {
  std::vector<std::byte> content;
  Appender append(content);
  append.u64(messages_);
  append.u16(static_cast<std::uint16_t>(schemas_.size()));
  append.u32(static_cast<std::uint32_t>(channels_.size()));
  append.u32(0);  // attachments
  append.u32(0);  // metadata
  append.u32(static_cast<std::uint32_t>(chunks_.size()));
  append.u64(first_ns_);
  append.u64(last_ns_);
  append.u32(static_cast<std::uint32_t>(channels_.size() * 10));
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    append.u16(static_cast<std::uint16_t>(i));
    append.u64(channels_[i].messages);
  }
  return content;
}

Status McapWriter::write_summary() {
  const std::uint64_t start = written_;
  std::vector<std::byte> out;
  std::vector<std::byte> groups;
  const auto end_group = [&](McapOp op, std::size_t begin) {
    if (out.size() == begin) return;
    std::vector<std::byte> content;
    Appender append(content);
    append.u8(static_cast<std::uint8_t>(op));
    append.u64(start + begin);
    append.u64(out.size() - begin);
    append_record(McapOp::kSummaryOffset, content, groups);
  };
  for (const Schema& schema : schemas_) Appender(out).bytes(schema.record);
  end_group(McapOp::kSchema, 0);
  std::size_t begin = out.size();
  for (const Channel& channel : channels_) Appender(out).bytes(channel.record);
  end_group(McapOp::kChannel, begin);
  begin = out.size();
  append_record(McapOp::kStatistics, statistics(), out);
  end_group(McapOp::kStatistics, begin);
  begin = out.size();
  for (const ChunkIndex& chunk : chunks_) {
    std::vector<std::byte> content;
    Appender append(content);
    append.u64(chunk.first_ns);
    append.u64(chunk.last_ns);
    append.u64(chunk.offset);
    append.u64(chunk.bytes);
    append.u32(static_cast<std::uint32_t>(chunk.index_offsets.size() * 10));
    for (const auto& [channel, offset] : chunk.index_offsets) {
      append.u16(channel);
      append.u64(offset);
    }
    append.u64(chunk.index_bytes);
    append.text32(mcap_name(options_.compression));
    append.u64(chunk.compressed_bytes);
    append.u64(chunk.uncompressed_bytes);
    append_record(McapOp::kChunkIndex, content, out);
  }
  end_group(McapOp::kChunkIndex, begin);
  const std::uint64_t groups_start = start + out.size();
  Appender append(out);
  append.bytes(groups);
  append.u8(static_cast<std::uint8_t>(McapOp::kFooter));
  append.u64(kMcapFooterBytes);
  append.u64(start);
  append.u64(groups_start);
  append.u32(crc32(out));
  append.text(kMcapMagic);
  return put(out);
}

Status McapWriter::close() {
  if (const Status status = begin(); !status) return status;
  if (const Status status = flush_chunk(); !status) return status;
  closed_ = true;
  // No CRC of the data section: writers differ in whether it covers magic and header, and each
  // chunk has its own.
  std::vector<std::byte> out;
  append_record(McapOp::kDataEnd, std::vector<std::byte>(kMcapDataEndBytes), out);
  if (const Status status = put(out); !status) return status;
  return write_summary();
}

}  // namespace rali::io
