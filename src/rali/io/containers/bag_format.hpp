#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "rali/base/time.hpp"
#include "rali/io/containers/cursor.hpp"
#include "rali/io/message_source.hpp"

// The ROS 1 bag format 2.0 (wiki.ros.org/Bags/Format/2.0): a line, then records, each a header of
// name=value fields and data. Chunks hold the messages and are followed by their index records;
// connections and chunk infos at the end of the file are the index of the whole file.
namespace rali::io {

inline constexpr std::string_view kBagMagic = "#ROSBAG V2.0\n";

enum class BagOp : std::uint8_t {
  kMessage = 2,
  kFileHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

// Longer headers are treated as damage: the longest field of a real one is a topic name.
inline constexpr std::uint32_t kBagHeaderBytesMax = 1U << 20;

/// The fields of one record header, not copied.
class BagFields {
 public:
  BagFields() = default;

  /// None if the lengths of the fields do not add up or there is no `op`.
  [[nodiscard]] static std::optional<BagFields> parse(std::span<const std::byte> header);

  [[nodiscard]] BagOp op() const { return op_; }

  [[nodiscard]] std::optional<std::span<const std::byte>> find(std::string_view name) const;
  [[nodiscard]] std::string_view text(std::string_view name) const;
  [[nodiscard]] std::optional<std::uint32_t> u32(std::string_view name) const;
  [[nodiscard]] std::optional<std::uint64_t> u64(std::string_view name) const;
  /// Seconds and nanoseconds, 32 bits each.
  [[nodiscard]] std::optional<Time> time(std::string_view name) const;

 private:
  std::span<const std::byte> header_;
  BagOp op_ = BagOp::kMessage;
};

/// A record within bytes in memory.
struct BagRecord {
  BagFields fields;
  std::span<const std::byte> data;
};

/// The next record; none if its header is damaged or its data ends after the bytes.
[[nodiscard]] std::optional<BagRecord> read_bag_record(Cursor& cursor);

/// Connection number and topic of a connection record; none if it is damaged.
[[nodiscard]] std::optional<std::pair<std::uint32_t, Topic>> bag_connection(
    const BagRecord& record);

}  // namespace rali::io
