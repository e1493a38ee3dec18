#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rali/factlog/record.hpp"

namespace rali::factlog {

/// What a segment holds.
struct SegmentScan {
  struct Record {
    RecordHead head;
    std::uint64_t offset = 0;  ///< of the head
  };

  struct Damage {
    std::uint64_t offset = 0, bytes = 0;
  };

  std::vector<Record> records;  ///< by place; head and body are as they were written
  std::vector<Damage> damages;  ///< between records, or before the first; by place
  std::uint64_t whole_end = 0;  ///< end of the last whole record, or of the segment's head
  SegmentHead head = SegmentHead::kGood;
};

/// Reads all whole records of a segment. After damage it goes on at the next whole record. Bytes
/// after `whole_end` are torn: they are no `damages`. Any bytes are answered; the work is bounded
/// by a few times their number.
[[nodiscard]] SegmentScan scan_segment(std::span<const std::byte> bytes, std::uint32_t segment);

}  // namespace rali::factlog
