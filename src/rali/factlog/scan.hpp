#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rali/factlog/record.hpp"

namespace rali::factlog {

/// Content of a segment.
struct SegmentScan {
  struct Record {
    RecordHead head;
    std::uint64_t offset = 0;  ///< of the head
  };

  struct Damage {
    std::uint64_t offset = 0, bytes = 0;
  };

  std::vector<Record> records;  ///< by offset; head and body have valid checksums
  std::vector<Damage> damages;  ///< between records, or before the first; by offset
  std::uint64_t whole_end = 0;  ///< end of the last whole record, or of the segment's head
  SegmentHead head = SegmentHead::kGood;
};

/// Reads all whole records of a segment. After damage it resumes at the next whole record. Bytes
/// after `whole_end` are torn: they are no `damages`. Any input is accepted; the work is bounded by
/// a few times its size.
[[nodiscard]] SegmentScan scan_segment(std::span<const std::byte> bytes, std::uint32_t segment);

}  // namespace rali::factlog
