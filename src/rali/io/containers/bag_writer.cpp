#include "rali/io/containers/bag_writer.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "rali/io/containers/bag_format.hpp"

namespace rali::io {
namespace {

// The first record is padded to this size, so that the index offset can be inserted at the end.
constexpr std::size_t kFileHeaderBytes = 4096;
constexpr std::int64_t kNsPerS = 1'000'000'000;

/// Builds the fields of a record header.
class Header {
 public:
  explicit Header(BagOp op) {
    const auto value = static_cast<std::byte>(op);
    add("op", std::span(&value, 1));
  }

  Header& add(std::string_view name, std::span<const std::byte> value) {
    Appender append(bytes_);
    append.u32(static_cast<std::uint32_t>(name.size() + 1 + value.size()));
    append.text(name);
    append.u8('=');
    append.bytes(value);
    return *this;
  }

  Header& text(std::string_view name, std::string_view value) { return add(name, bytes_of(value)); }

  Header& u32(std::string_view name, std::uint32_t value) {
    std::vector<std::byte> bytes;
    Appender(bytes).u32(value);
    return add(name, bytes);
  }

  Header& u64(std::string_view name, std::uint64_t value) {
    std::vector<std::byte> bytes;
    Appender(bytes).u64(value);
    return add(name, bytes);
  }

  Header& time(std::string_view name, Time t) {
    std::vector<std::byte> bytes;
    Appender append(bytes);
    append.u32(static_cast<std::uint32_t>(t.ns / kNsPerS));
    append.u32(static_cast<std::uint32_t>(t.ns % kNsPerS));
    return add(name, bytes);
  }

  /// Appends the whole record.
  void record(std::span<const std::byte> data, std::vector<std::byte>& out) const {
    Appender append(out);
    append.u32(static_cast<std::uint32_t>(bytes_.size()));
    append.bytes(bytes_);
    append.u32(static_cast<std::uint32_t>(data.size()));
    append.bytes(data);
  }

  [[nodiscard]] std::size_t size() const { return bytes_.size(); }

 private:
  std::vector<std::byte> bytes_;
};

void append_field(std::string_view name, std::string_view value, std::vector<std::byte>& out) {
  Appender append(out);
  append.u32(static_cast<std::uint32_t>(name.size() + 1 + value.size()));
  append.text(name);
  append.u8('=');
  append.text(value);
}

}  // namespace

Status BagWriter::put(std::span<const std::byte> bytes) {
  written_ += bytes.size();
  return sink_.write(bytes);
}

std::vector<std::byte> BagWriter::file_header(std::uint64_t index_offset) const {
  Header header(BagOp::kFileHeader);
  header.u64("index_pos", index_offset);
  header.u32("conn_count", index_offset == 0 ? 0 : static_cast<std::uint32_t>(connections_.size()));
  header.u32("chunk_count", index_offset == 0 ? 0 : static_cast<std::uint32_t>(chunks_.size()));
  const std::vector<std::byte> padding(kFileHeaderBytes - header.size() - 8, std::byte{' '});
  std::vector<std::byte> out;
  header.record(padding, out);
  return out;
}

Status BagWriter::begin() {
  if (closed_) return fail(ErrorCode::kUsage, "bag", "written to after it was closed");
  if (written_ > 0) return {};
  if (const Status status = put(bytes_of(kBagMagic)); !status) return status;
  return put(file_header(0));
}

Result<std::uint32_t> BagWriter::add_connection(const std::string& topic, const std::string& type,
                                                const std::string& md5sum,
                                                const std::string& definition) {
  const auto number = static_cast<std::uint32_t>(connections_.size());
  std::vector<std::byte> data;
  append_field("topic", topic, data);
  append_field("type", type, data);
  append_field("md5sum", md5sum, data);
  append_field("message_definition", definition, data);
  Connection connection;
  Header(BagOp::kConnection)
      .u32("conn", number)
      .text("topic", topic)
      .record(data, connection.record);
  connections_.push_back(std::move(connection));
  return number;
}

Status BagWriter::write(std::uint32_t connection, Time t, std::span<const std::byte> data) {
  if (const Status status = begin(); !status) return status;
  if (connection >= connections_.size()) {
    return fail(ErrorCode::kUsage, "bag", fmt::format("no connection {}", connection));
  }
  if (t.ns < 0 || t.ns / kNsPerS > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::kInput, "bag", fmt::format("time {} ns does not fit a ROS 1 bag", t.ns));
  }
  if (data.size() > std::numeric_limits<std::int32_t>::max()) {
    return fail(ErrorCode::kInput, "bag", "a message must be smaller than 2 GiB");
  }
  Connection& known = connections_[connection];
  if (!known.in_file) Appender(chunk_).bytes(known.record);
  known.in_file = true;
  chunk_index_[connection].push_back({t, static_cast<std::uint32_t>(chunk_.size())});
  Header(BagOp::kMessage).u32("conn", connection).time("time", t).record(data, chunk_);
  return chunk_.size() >= options_.chunk_bytes ? flush_chunk() : Status();
}

Status BagWriter::flush_chunk() {
  if (chunk_.empty()) return {};
  const auto packed = compress(options_.compression, chunk_);
  if (!packed) return tl::make_unexpected(packed.error());
  ChunkInfo info{written_, chunk_index_.begin()->second.front().t, {}, {}};
  info.last = info.first;
  std::vector<std::byte> out;
  Header(BagOp::kChunk)
      .text("compression", name_of(options_.compression))
      .u32("size", static_cast<std::uint32_t>(chunk_.size()))
      .record(*packed, out);
  for (const auto& [number, entries] : chunk_index_) {
    std::vector<std::byte> data;
    for (const IndexEntry& entry : entries) {
      info.first = std::min(info.first, entry.t);
      info.last = std::max(info.last, entry.t);
      Appender append(data);
      append.u32(static_cast<std::uint32_t>(entry.t.ns / kNsPerS));
      append.u32(static_cast<std::uint32_t>(entry.t.ns % kNsPerS));
      append.u32(entry.offset);
    }
    const auto count = static_cast<std::uint32_t>(entries.size());
    info.counts[number] = count;
    Header(BagOp::kIndex).u32("ver", 1).u32("conn", number).u32("count", count).record(data, out);
  }
  chunks_.push_back(std::move(info));
  chunk_.clear();
  chunk_index_.clear();
  return put(out);
}

Status BagWriter::close() {
  if (const Status status = begin(); !status) return status;
  if (const Status status = flush_chunk(); !status) return status;
  closed_ = true;
  const std::uint64_t index_offset = written_;
  std::vector<std::byte> out;
  for (const Connection& connection : connections_) Appender(out).bytes(connection.record);
  for (const ChunkInfo& info : chunks_) {
    std::vector<std::byte> data;
    Appender append(data);
    for (const auto& [number, count] : info.counts) {
      append.u32(number);
      append.u32(count);
    }
    Header(BagOp::kChunkInfo)
        .u32("ver", 1)
        .u64("chunk_pos", info.offset)
        .time("start_time", info.first)
        .time("end_time", info.last)
        .u32("count", static_cast<std::uint32_t>(info.counts.size()))
        .record(data, out);
  }
  if (const Status status = put(out); !status) return status;
  return sink_.overwrite(kBagMagic.size(), file_header(index_offset));
}

}  // namespace rali::io
