#include "rali/io/containers/mcap_summary.hpp"

#include <algorithm>
#include <cstring>

#include "rali/io/containers/codec.hpp"
#include "rali/io/containers/crc32.hpp"

namespace rali::io {
namespace {

constexpr std::size_t kBlock = 1U << 20;
constexpr std::uint64_t kSummaryBytesMax = 1U << 28;
// Limit for schemas and channels before the first chunk or message.
constexpr int kLookRecords = 200;
constexpr std::size_t kTailBytes = kMcapRecordHeaderBytes + kMcapFooterBytes + 8;

struct Footer {
  std::uint64_t summary_start = 0;
  std::uint32_t crc = 0;
};

/// The footer, located right before the closing magic.
Result<std::optional<Footer>> read_footer(ByteSource& source, ByteWindow& window) {
  if (source.size() < kTailBytes + kMcapMagic.size()) return std::nullopt;
  const auto tail = window.view(source.size() - kTailBytes, kTailBytes);
  if (!tail) return tl::make_unexpected(tail.error());
  Cursor cursor(*tail);
  const auto record = read_mcap_record(cursor);
  if (!record || record->op != McapOp::kFooter || text_of(cursor.rest()) != kMcapMagic) {
    return std::nullopt;
  }
  Cursor content(record->content);
  Footer footer;
  footer.summary_start = content.u64();
  content.u64();  // the summary's own index
  footer.crc = content.u32();
  return footer;
}

Result<std::uint32_t> crc_of(ByteWindow& window, std::uint64_t begin, std::uint64_t end) {
  std::uint32_t crc = 0;
  while (begin < end) {
    const auto bytes =
        window.view(begin, static_cast<std::size_t>(std::min<std::uint64_t>(kBlock, end - begin)));
    if (!bytes) return tl::make_unexpected(bytes.error());
    crc = crc32(*bytes, crc);
    begin += bytes->size();
  }
  return crc;
}

/// Processes one record of the summary; false if it is damaged.
bool take_record(const McapRecord& record, McapSummary& summary) {
  if (record.op == McapOp::kSchema) {
    auto schema = mcap_schema(record.content);
    if (schema) summary.schemas.push_back(std::move(*schema));
    return schema.has_value();
  }
  if (record.op == McapOp::kChannel) {
    auto channel = mcap_channel(record.content);
    if (channel) summary.channels.push_back(std::move(*channel));
    return channel.has_value();
  }
  if (record.op == McapOp::kChunkIndex) {
    const auto chunk = mcap_chunk_index(record.content);
    if (chunk) summary.chunks.push_back(*chunk);
    return chunk.has_value();
  }
  if (record.op == McapOp::kStatistics) {
    summary.statistics = mcap_statistics(record.content);
    return summary.statistics.has_value();
  }
  return true;
}

/// True if the bytes start a chunk record: the length of the record and that of its compressed
/// records agree, which is very unlikely by chance in 128 bits.
bool is_chunk(std::span<const std::byte> bytes) {
  Cursor cursor(bytes);
  if (static_cast<McapOp>(cursor.u8()) != McapOp::kChunk) return false;
  const std::uint64_t length = cursor.u64();
  // Checked first: this rejects nearly every byte that happens to be 6.
  if (!cursor.ok() || length >> 40 != 0) return false;
  const auto chunk = mcap_chunk(cursor.rest());
  return chunk && chunk->record_bytes == length - chunk->header_bytes &&
         compression_named(chunk->compression);
}

}  // namespace

std::optional<bool> McapSummary::in_order() const {
  // Messages outside chunks are not indexed.
  const bool all = statistics && statistics->chunks == chunks.size() &&
                   (statistics->messages == 0 || !chunks.empty());
  if (!all) return std::nullopt;
  std::vector<McapChunkIndex> by_offset = chunks;
  std::sort(by_offset.begin(), by_offset.end(),
            [](const auto& a, const auto& b) { return a.offset < b.offset; });
  std::vector<std::pair<Time, Time>> spans;
  for (const McapChunkIndex& chunk : by_offset) {
    spans.emplace_back(time_of_ns(chunk.first_ns), time_of_ns(chunk.last_ns));
  }
  return spans_in_order(spans);
}

Result<std::optional<McapSummary>> read_mcap_summary(ByteSource& source, ByteWindow& window,
                                                     const ReadLimits& limits, std::string& why) {
  const auto footer = read_footer(source, window);
  if (!footer) return tl::make_unexpected(footer.error());
  why = "no closing record at the end (the recording was not closed, is cut, or was added to)";
  if (!*footer) return std::nullopt;
  why = "no summary";
  const std::uint64_t begin = (*footer)->summary_start;
  const std::uint64_t end = source.size() - kTailBytes;
  if (begin == 0) return std::nullopt;
  why = "damaged summary";
  if (begin > end || end - begin > std::min(limits.chunk_bytes, kSummaryBytesMax)) {
    return std::nullopt;
  }
  // The CRC covers the bytes up to itself, the last number of the footer.
  const auto crc = crc_of(window, begin, source.size() - kMcapMagic.size() - 4);
  if (!crc) return tl::make_unexpected(crc.error());
  if ((*footer)->crc != 0 && *crc != (*footer)->crc) return std::nullopt;
  const auto bytes = window.view(begin, static_cast<std::size_t>(end - begin));
  if (!bytes) return tl::make_unexpected(bytes.error());
  Cursor cursor(*bytes);
  McapSummary summary;
  while (cursor.left() > 0) {
    const auto record = read_mcap_record(cursor);
    if (!record || !take_record(*record, summary)) return std::nullopt;
  }
  return summary;
}

Result<std::string> first_mcap_compression(ByteSource& source, ByteWindow& window) {
  std::uint64_t offset = kMcapMagic.size();
  for (int i = 0; i < kLookRecords && offset < source.size(); ++i) {
    const auto bytes = window.view(offset, kMcapRecordHeaderBytes + McapChunkHeader::kBytesMax);
    if (!bytes) return tl::make_unexpected(bytes.error());
    Cursor cursor(*bytes);
    const auto op = static_cast<McapOp>(cursor.u8());
    const std::uint64_t length = cursor.u64();
    if (!cursor.ok() || length > source.size()) break;
    if (op == McapOp::kMessage) return "none";
    if (op == McapOp::kChunk) {
      const auto chunk = mcap_chunk(cursor.rest());
      const auto known = chunk ? compression_named(chunk->compression) : std::nullopt;
      return known ? std::string(name_of(*known)) : std::string();
    }
    offset += kMcapRecordHeaderBytes + length;
  }
  return std::string();
}

Result<std::optional<std::uint64_t>> find_mcap_chunk(ByteSource& source, ByteWindow& window,
                                                     std::uint64_t from, DamageSearch& search) {
  constexpr std::size_t kSeam = kMcapRecordHeaderBytes + McapChunkHeader::kBytesMax;
  while (true) {
    const auto block = search.next(source, window, from);
    if (!block) return tl::make_unexpected(block.error());
    if (!*block) return std::nullopt;
    const std::span<const std::byte> bytes = (*block)->bytes;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const void* hit =
          std::memchr(bytes.data() + i, static_cast<int>(McapOp::kChunk), bytes.size() - i);
      if (hit == nullptr) break;
      i = static_cast<std::size_t>(static_cast<const std::byte*>(hit) - bytes.data());
      if (is_chunk(bytes.subspan(i, std::min(kSeam, bytes.size() - i)))) {
        return (*block)->offset + i;
      }
    }
    const std::uint64_t end = (*block)->offset + bytes.size();
    if (end >= source.size()) return std::nullopt;
    from = end - kSeam;
  }
}

Result<std::optional<std::uint64_t>> end_of_mcap(ByteSource& source, ByteWindow& window,
                                                 std::uint64_t offset) {
  while (offset < source.size()) {
    const auto bytes = window.view(offset, kMcapRecordHeaderBytes);
    if (!bytes) return tl::make_unexpected(bytes.error());
    Cursor cursor(*bytes);
    const auto op = static_cast<McapOp>(cursor.u8());
    const std::uint64_t length = cursor.u64();
    if (!cursor.ok() || op == McapOp{0}) return std::nullopt;
    if (length > source.size() - offset - kMcapRecordHeaderBytes) return std::nullopt;
    offset += kMcapRecordHeaderBytes + length;
    if (op != McapOp::kFooter) continue;
    const auto magic = window.view(offset, kMcapMagic.size());
    if (!magic) return tl::make_unexpected(magic.error());
    if (length != kMcapFooterBytes || text_of(*magic) != kMcapMagic) return std::nullopt;
    return offset + kMcapMagic.size();
  }
  return std::nullopt;
}

Result<std::uint64_t> count_mcap_index(ByteSource& source, ByteWindow& window,
                                       std::uint64_t offset) {
  constexpr std::size_t kEntryBytes = 16;
  constexpr std::size_t kHeadBytes = kMcapRecordHeaderBytes + 2 + 4;
  std::uint64_t messages = 0;
  while (offset < source.size()) {
    const auto bytes = window.view(offset, kHeadBytes);
    if (!bytes) return tl::make_unexpected(bytes.error());
    Cursor cursor(*bytes);
    const auto op = static_cast<McapOp>(cursor.u8());
    const std::uint64_t length = cursor.u64();
    cursor.u16();  // channel
    const std::uint64_t entry_bytes = cursor.u32();
    if (!cursor.ok() || op != McapOp::kMessageIndex || length != entry_bytes + 6) break;
    if (length > source.size() - offset) break;
    messages += entry_bytes / kEntryBytes;
    offset += kMcapRecordHeaderBytes + length;
  }
  return messages;
}

}  // namespace rali::io
