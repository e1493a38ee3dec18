// Any bytes as a segment of the log: the records read lie within it, in order, with matching
// checksums, and stay the same if only whole records are kept. The first byte is the number of
// heads that are corrected; otherwise no record would pass its checksum.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "rali/base/crc32c.hpp"
#include "rali/factlog/role_slots.hpp"
#include "rali/factlog/scan.hpp"

namespace {

using rali::factlog::Bytes;

constexpr std::uint32_t kSegment = 1;

/// Writes whole records over the bytes without changing their bodies.
void put_right(Bytes& bytes, unsigned records) {
  using namespace rali::factlog;
  std::size_t at = kSegmentHeadBytes;
  for (unsigned k = 0; k < records && at + kRecordHeadBytes < bytes.size(); ++k) {
    const std::size_t left = bytes.size() - at - kRecordHeadBytes;
    const std::size_t length = std::to_integer<std::size_t>(bytes[at + 4]) % (left + 1);
    const auto seq = std::to_integer<std::uint32_t>(bytes[at + 5]);
    const auto body = std::span(bytes).subspan(at + kRecordHeadBytes, length);
    const Bytes record = encode_record({rali::VehicleId{1}, 0, seq}, 3, body, {kSegment, at});
    std::copy(record.begin(), record.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
    // Leaves some bytes between this record and the next.
    at += record.size() + std::to_integer<std::size_t>(bytes[at + kRecordHeadBytes - 1]) % 3;
  }
}

void check(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace rali::factlog;
  if (size == 0) return 0;
  const auto given = std::as_bytes(std::span(data + 1, size - 1));
  Bytes bytes(given.begin(), given.end());
  put_right(bytes, data[0] % 8U);
  const SegmentScan scan = scan_segment(bytes, kSegment);
  check(scan.whole_end <= bytes.size());
  std::uint64_t end = 0;
  for (const SegmentScan::Record& r : scan.records) {
    check(r.offset >= kSegmentHeadBytes && r.offset >= end);
    end = r.offset + r.head.bytes();
    check(end <= scan.whole_end);
    const auto body = std::span(bytes).subspan(r.offset + kRecordHeadBytes, r.head.body_bytes);
    check(rali::crc32c(body) == r.head.body_crc);
  }
  for (const SegmentScan::Damage& d : scan.damages) check(d.offset + d.bytes <= scan.whole_end);
  const SegmentScan again = scan_segment(std::span(bytes).first(scan.whole_end), kSegment);
  check(again.records.size() == scan.records.size() && again.whole_end == scan.whole_end);

  MemorySlots slots;
  std::copy_n(given.begin(), std::min(given.size(), slots.bytes().size()), slots.bytes().begin());
  check(slots.reopened().content().size() <= kSlotContentMax);
  return 0;
}
