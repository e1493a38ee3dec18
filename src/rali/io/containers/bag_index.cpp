#include "rali/io/containers/bag_index.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "rali/io/containers/codec.hpp"

namespace rali::io {
namespace {

constexpr std::string_view kChunkMark = "compression=";
// "op", "size", "compression=" and their lengths fit easily.
constexpr std::uint32_t kChunkHeaderMax = 256;

/// First and last time of each chunk, by its offset.
using ChunkSpans = std::map<std::uint64_t, std::pair<Time, Time>>;

/// Parses one chunk info record; false if damaged.
bool add_chunk_info(const BagRecord& record, BagIndex& index, ChunkSpans& spans) {
  const auto offset = record.fields.u64("chunk_pos");
  const auto first = record.fields.time("start_time");
  const auto last = record.fields.time("end_time");
  if (!offset || !first || !last) return false;
  Cursor cursor(record.data);
  std::uint64_t messages = 0;
  while (cursor.left() > 0) {
    const std::uint32_t connection = cursor.u32();
    const std::uint32_t count = cursor.u32();
    if (!cursor.ok()) return false;
    index.counts[connection] += count;
    messages += count;
  }
  index.chunks.emplace_back(*offset, messages);
  if (messages == 0) return true;
  spans.emplace(*offset, std::make_pair(*first, *last));
  if (!index.span) index.span = {*first, *last};
  index.span->first = std::min(index.span->first, *first);
  index.span->second = std::max(index.span->second, *last);
  return true;
}

bool add_index_record(const BagRecord& record, BagIndex& index, ChunkSpans& spans) {
  if (record.fields.op() == BagOp::kChunkInfo) return add_chunk_info(record, index, spans);
  if (record.fields.op() != BagOp::kConnection) return false;
  auto connection = bag_connection(record);
  if (!connection) return false;
  index.connections.push_back(std::move(*connection));
  return true;
}

/// True if the bytes start with a record header that describes a chunk.
bool is_chunk_header(std::span<const std::byte> bytes) {
  Cursor cursor(bytes);
  const std::uint32_t header_bytes = cursor.u32();
  if (header_bytes > kChunkHeaderMax) return false;
  const auto header = cursor.bytes(header_bytes);
  if (!cursor.ok()) return false;
  const auto fields = BagFields::parse(header);
  return fields && fields->op() == BagOp::kChunk && fields->u32("size") &&
         compression_named(fields->text("compression"));
}

}  // namespace

Result<BagFileHeader> read_bag_file_header(ByteSource& source, ByteWindow& window) {
  BagFileHeader out;
  out.end = kBagMagic.size();
  const auto bytes = window.view(kBagMagic.size(), 64 * 1024);
  if (!bytes) return tl::make_unexpected(bytes.error());
  Cursor cursor(*bytes);
  const auto record = read_bag_record(cursor);
  if (!record || record->fields.op() != BagOp::kFileHeader) return out;
  const std::string_view encryptor = record->fields.text("encryptor");
  if (!encryptor.empty()) {
    return fail(ErrorCode::kInput, source.name(), fmt::format("encrypted bag ({})", encryptor),
                "Decrypt it first with rosbag decrypt.");
  }
  out.index_offset = record->fields.u64("index_pos").value_or(0);
  out.connections = record->fields.u32("conn_count").value_or(0);
  out.chunks = record->fields.u32("chunk_count").value_or(0);
  out.end = kBagMagic.size() + cursor.at();
  return out;
}

Result<std::optional<BagIndex>> read_bag_index(ByteSource& source, ByteWindow& window,
                                               std::uint64_t offset, const ReadLimits& limits) {
  BagIndex index;
  ChunkSpans spans;
  const std::uint64_t size = source.size();
  while (offset < size) {
    auto bytes = window.view(offset, 8);
    if (!bytes) return tl::make_unexpected(bytes.error());
    const std::uint64_t header_bytes = Cursor(*bytes).u32();
    bytes = window.view(offset + 4 + header_bytes, 4);
    if (!bytes) return tl::make_unexpected(bytes.error());
    const std::uint64_t record_bytes = 8 + header_bytes + Cursor(*bytes).u32();
    if (record_bytes > size - offset || record_bytes > limits.definition_bytes) return std::nullopt;
    bytes = window.view(offset, static_cast<std::size_t>(record_bytes));
    if (!bytes) return tl::make_unexpected(bytes.error());
    Cursor cursor(*bytes);
    const auto record = read_bag_record(cursor);
    if (!record || !add_index_record(*record, index, spans)) return std::nullopt;
    offset += record_bytes;
  }
  std::sort(index.chunks.begin(), index.chunks.end());
  std::vector<std::pair<Time, Time>> in_file_order;
  for (const auto& chunk : spans) in_file_order.push_back(chunk.second);
  index.in_order = spans_in_order(in_file_order);
  return index;
}

Result<std::optional<std::uint64_t>> find_bag_chunk(ByteSource& source, ByteWindow& window,
                                                    std::uint64_t from, DamageSearch& search) {
  while (true) {
    const auto block = search.next(source, window, from);
    if (!block) return tl::make_unexpected(block.error());
    if (!*block) return std::nullopt;
    const std::span<const std::byte> bytes = (*block)->bytes;
    const std::string_view text = text_of(bytes);
    for (std::size_t hit = text.find(kChunkMark); hit != std::string_view::npos;
         hit = text.find(kChunkMark, hit + 1)) {
      for (std::size_t start = hit - std::min<std::size_t>(hit, kChunkHeaderMax); start < hit;
           ++start) {
        if (is_chunk_header(bytes.subspan(start))) return (*block)->offset + start;
      }
    }
    const std::uint64_t end = (*block)->offset + bytes.size();
    if (end >= source.size()) return std::nullopt;
    // Blocks overlap by a header, so that none is missed at a block boundary.
    from = end - 2 * kChunkHeaderMax;
  }
}

}  // namespace rali::io
