#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rali/io/containers/cursor.hpp"

// The MCAP format 0 (mcap.dev/spec): magic, records of opcode, 64-bit length and content, magic.
namespace rali::io {

inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);
inline constexpr std::size_t kMcapRecordHeaderBytes = 9;
inline constexpr std::size_t kMcapFooterBytes = 20;
inline constexpr std::size_t kMcapDataEndBytes = 4;

enum class McapOp : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F
};

/// A record within bytes in memory.
struct McapRecord {
  McapOp op;
  std::span<const std::byte> content;
};

/// The next record; none if it ends after the bytes.
[[nodiscard]] std::optional<McapRecord> read_mcap_record(Cursor& cursor);

struct McapSchema {
  std::uint16_t id = 0;
  std::string name;
  std::string encoding;
  std::string data;
};

struct McapChannel {
  std::uint16_t id = 0;
  std::uint16_t schema = 0;  ///< 0: none
  std::string topic;
  std::string encoding;
};

/// Fields of a message record before its data.
struct McapMessageHeader {
  static constexpr std::size_t kBytes = 22;
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_ns = 0;
  std::uint64_t publish_ns = 0;
};

/// Fields of a chunk record before its records.
struct McapChunkHeader {
  static constexpr std::size_t kBytesMin = 40;
  /// More than any compression's name needs.
  static constexpr std::size_t kBytesMax = kBytesMin + 32;
  std::uint64_t uncompressed_bytes = 0;
  std::uint32_t uncompressed_crc = 0;  ///< 0: not given
  std::string compression;
  std::uint64_t record_bytes = 0;  ///< as stored in the file
  std::size_t header_bytes = 0;
};

/// Position of a chunk in the file and its time span.
struct McapChunkIndex {
  std::uint64_t first_ns = 0;
  std::uint64_t last_ns = 0;
  std::uint64_t offset = 0;
};

struct McapStatistics {
  std::uint64_t messages = 0;
  std::uint32_t channels = 0;
  std::uint32_t chunks = 0;
  std::uint64_t first_ns = 0;
  std::uint64_t last_ns = 0;
  std::vector<std::pair<std::uint16_t, std::uint64_t>> counts;  ///< channel, messages
};

// Each gives none if the content is too short.
[[nodiscard]] std::optional<McapSchema> mcap_schema(std::span<const std::byte> content);
[[nodiscard]] std::optional<McapChannel> mcap_channel(std::span<const std::byte> content);
[[nodiscard]] std::optional<McapMessageHeader> mcap_message(std::span<const std::byte> content);
[[nodiscard]] std::optional<McapChunkHeader> mcap_chunk(std::span<const std::byte> content);
[[nodiscard]] std::optional<McapChunkIndex> mcap_chunk_index(std::span<const std::byte> content);
[[nodiscard]] std::optional<McapStatistics> mcap_statistics(std::span<const std::byte> content);

}  // namespace rali::io
