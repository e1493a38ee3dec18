#include "rali/factlog/record.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "rali/base/assert.hpp"
#include "rali/base/crc32c.hpp"
#include "rali/factlog/bytes.hpp"

namespace rali::factlog {

namespace {

// Of a record: magic u32, body length u32, vehicle u16, kind u8, zero u8, epoch u32, seq u32,
// checksum of the body u32, checksum of the head and its place u32.
constexpr std::uint32_t kMagic = 0x7E46C3A5U;
constexpr std::size_t kHeadCrcAt = 24;

constexpr std::string_view kSegmentMagic = "RALIFACT";
constexpr std::uint32_t kSegmentVersion = 1;

std::uint32_t head_crc(std::span<const std::byte> head, const RecordPlace& place) {
  Bytes where;
  put(where, place.segment);
  put(where, place.offset);
  return crc32c(head.first(kHeadCrcAt), crc32c(where));
}

}  // namespace

Bytes encode_record(const RecordKey& key, std::uint8_t kind, std::span<const std::byte> body,
                    const RecordPlace& place) {
  RALI_ASSERT(body.size() <= kBodyMax);
  Bytes out;
  out.reserve(kRecordHeadBytes + body.size());
  put(out, kMagic);
  put(out, static_cast<std::uint32_t>(body.size()));
  put(out, key.vehicle.value);
  put(out, kind);
  put(out, std::uint8_t{0});
  put(out, key.epoch);
  put(out, key.seq);
  put(out, crc32c(body));
  put(out, head_crc(out, place));
  out.insert(out.end(), body.begin(), body.end());
  return out;
}

std::optional<RecordHead> decode_head(std::span<const std::byte> bytes, const RecordPlace& place) {
  if (bytes.size() < kRecordHeadBytes || get<std::uint32_t>(bytes, 0) != kMagic) return {};
  if (get<std::uint32_t>(bytes, kHeadCrcAt) != head_crc(bytes, place)) return {};
  RecordHead head;
  head.body_bytes = get<std::uint32_t>(bytes, 4);
  head.key.vehicle.value = get<std::uint16_t>(bytes, 8);
  head.kind = get<std::uint8_t>(bytes, 10);
  head.key.epoch = get<std::uint32_t>(bytes, 12);
  head.key.seq = get<std::uint32_t>(bytes, 16);
  head.body_crc = get<std::uint32_t>(bytes, 20);
  if (head.body_bytes > kBodyMax) return {};
  return head;
}

std::size_t next_magic(std::span<const std::byte> bytes, std::size_t from) {
  Bytes magic;
  put(magic, kMagic);
  const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(std::min(from, bytes.size()));
  return static_cast<std::size_t>(std::search(begin, bytes.end(), magic.begin(), magic.end()) -
                                  bytes.begin());
}

Bytes encode_segment_head() {
  Bytes out;
  for (const char c : kSegmentMagic) put(out, static_cast<std::uint8_t>(c));
  put(out, kSegmentVersion);
  put(out, crc32c(out));
  return out;
}

SegmentHead check_segment_head(std::span<const std::byte> bytes) {
  const Bytes good = encode_segment_head();
  if (bytes.size() < kSegmentHeadBytes) return SegmentHead::kDamaged;
  const auto head = bytes.first(kSegmentHeadBytes);
  if (std::equal(head.begin(), head.end(), good.begin())) return SegmentHead::kGood;
  const bool whole = std::equal(head.begin(), head.begin() + kSegmentMagic.size(), good.begin()) &&
                     get<std::uint32_t>(head, 12) == crc32c(head.first(12));
  return whole ? SegmentHead::kOtherVersion : SegmentHead::kDamaged;
}

}  // namespace rali::factlog
