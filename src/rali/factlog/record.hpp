#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rali/base/ids.hpp"

namespace rali::factlog {

using Bytes = std::vector<std::byte>;

/// Key of a record: that of the fact it stores.
struct RecordKey {
  VehicleId vehicle;
  std::uint32_t epoch = 0;
  std::uint32_t seq = 0;
  constexpr auto operator<=>(const RecordKey&) const = default;
};

inline constexpr std::size_t kRecordHeadBytes = 28;
inline constexpr std::size_t kSegmentHeadBytes = 16;
/// More than the largest message between vehicles: a greater length is damage.
inline constexpr std::size_t kBodyMax = std::size_t{2} << 20;

/// Position of a record. Its checksum includes this position, so that neither a block that a disk
/// wrote elsewhere nor a record within the body of another is taken for a record.
struct RecordPlace {
  std::uint32_t segment = 0;
  std::uint64_t offset = 0;  ///< of the record's head in the segment
};

struct RecordHead {
  RecordKey key;
  std::uint8_t kind = 0;
  std::uint32_t body_bytes = 0;
  std::uint32_t body_crc = 0;  ///< of the body alone: equal contents have equal checksums

  [[nodiscard]] std::size_t bytes() const { return kRecordHeadBytes + body_bytes; }
};

/// Encoded head and body. `body` has at most kBodyMax bytes.
[[nodiscard]] Bytes encode_record(const RecordKey& key, std::uint8_t kind,
                                  std::span<const std::byte> body, const RecordPlace& place);

/// The head at the start of `bytes`, if it is valid for this place.
[[nodiscard]] std::optional<RecordHead> decode_head(std::span<const std::byte> bytes,
                                                    const RecordPlace& place);

/// The first offset from `from` on where a head may start; the size of `bytes` if there is none.
[[nodiscard]] std::size_t next_magic(std::span<const std::byte> bytes, std::size_t from);

[[nodiscard]] Bytes encode_segment_head();

enum class SegmentHead { kGood, kDamaged, kOtherVersion };

[[nodiscard]] SegmentHead check_segment_head(std::span<const std::byte> bytes);

}  // namespace rali::factlog
