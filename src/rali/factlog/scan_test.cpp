#include "rali/factlog/scan.hpp"

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/factlog/folder_for_test.hpp"

namespace rali::factlog {
namespace {

constexpr std::uint32_t kSegment = 5;

/// A segment of records 0, 1, ... with bodies of these lengths.
Bytes segment_of(const std::vector<std::size_t>& lengths) {
  Bytes out = encode_segment_head();
  for (std::uint32_t seq = 0; seq < lengths.size(); ++seq) {
    const Bytes record =
        encode_record(key_of(seq), 3, body_of(seq, lengths[seq]), {kSegment, out.size()});
    out.insert(out.end(), record.begin(), record.end());
  }
  return out;
}

Bytes body_in(const Bytes& segment, const SegmentScan::Record& record) {
  const auto begin =
      segment.begin() + static_cast<std::ptrdiff_t>(record.offset + kRecordHeadBytes);
  return {begin, begin + static_cast<std::ptrdiff_t>(record.head.body_bytes)};
}

/// Each record that is read was written, with this content.
void expect_only_written(const Bytes& bytes, const SegmentScan& scan,
                         const std::vector<std::size_t>& lengths, const std::string& where) {
  for (const SegmentScan::Record& r : scan.records) {
    ASSERT_LT(r.head.key.seq, lengths.size()) << where;
    EXPECT_EQ(r.head.key, key_of(r.head.key.seq)) << where;
    EXPECT_EQ(body_in(bytes, r), body_of(r.head.key.seq, lengths[r.head.key.seq])) << where;
  }
}

TEST(Scan, a_segment_gives_the_records_that_were_written) {
  const Bytes segment = segment_of({10, 0, 300});
  ASSERT_EQ(segment.size(), 16U + 38U + 28U + 328U);
  const SegmentScan scan = scan_segment(segment, kSegment);
  ASSERT_EQ(scan.records.size(), 3U);
  EXPECT_EQ(scan.head, SegmentHead::kGood);
  EXPECT_TRUE(scan.damages.empty());
  EXPECT_EQ(scan.whole_end, segment.size());
  EXPECT_EQ(scan.records[1].offset, 54U);
  EXPECT_EQ(scan.records[2].head.kind, 3);
  EXPECT_EQ(body_in(segment, scan.records[2]), body_of(2, 300));
}

TEST(Scan, a_record_truncated_at_any_byte_is_dropped_and_earlier_ones_kept) {
  const std::vector<std::size_t> lengths = {10, 0, 60};
  const Bytes segment = segment_of(lengths);
  const std::size_t last = segment.size() - (kRecordHeadBytes + 60);
  for (std::size_t size = last; size < segment.size(); ++size) {
    const Bytes torn(segment.begin(), segment.begin() + static_cast<std::ptrdiff_t>(size));
    const SegmentScan scan = scan_segment(torn, kSegment);
    EXPECT_EQ(scan.records.size(), 2U) << size;
    EXPECT_EQ(scan.whole_end, last) << size;
    EXPECT_TRUE(scan.damages.empty()) << size;
  }
}

// A power loss may leave a disk with the new length but no content.
TEST(Scan, zeros_at_the_end_are_torn_bytes) {
  Bytes segment = segment_of({10, 20});
  const std::size_t whole = segment.size();
  segment.resize(whole + 5000);
  const SegmentScan scan = scan_segment(segment, kSegment);
  EXPECT_EQ(scan.records.size(), 2U);
  EXPECT_EQ(scan.whole_end, whole);
}

TEST(Scan, a_flipped_bit_loses_at_most_one_record_and_creates_none) {
  const std::vector<std::size_t> lengths = {40, 7, 0, 90};
  const Bytes good = segment_of(lengths);
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Bytes bytes = good;
    bytes[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    const SegmentScan scan = scan_segment(bytes, kSegment);
    expect_only_written(bytes, scan, lengths, std::to_string(bit));
    const bool in_head = bit / 8 < kSegmentHeadBytes;
    EXPECT_EQ(scan.head != SegmentHead::kGood, in_head) << bit;
    EXPECT_EQ(scan.records.size(), in_head ? 4U : 3U) << bit;
  }
}

TEST(Scan, continues_at_the_next_whole_record_after_damage) {
  Bytes segment = segment_of({40, 50, 60});
  const std::size_t second = 16 + 68;
  segment[second + 4] ^= std::byte{0xFF};  // its length
  const SegmentScan scan = scan_segment(segment, kSegment);
  ASSERT_EQ(scan.records.size(), 2U);
  EXPECT_EQ(scan.records[1].head.key.seq, 2U);
  ASSERT_EQ(scan.damages.size(), 1U);
  EXPECT_EQ(scan.damages[0].offset, second);
  EXPECT_EQ(scan.damages[0].bytes, 78U);
}

// A sender of facts could put a whole record into one; if that fact is damaged, its content must
// not become a fact of another vehicle.
TEST(Scan, ignores_a_record_inside_the_body_of_a_damaged_one) {
  const Bytes inner = encode_record({VehicleId{1}, 0, 7}, 3, body_of(7, 30), {kSegment, 0});
  Bytes segment = encode_segment_head();
  const Bytes outer = encode_record(key_of(0), 3, inner, {kSegment, segment.size()});
  segment.insert(segment.end(), outer.begin(), outer.end());
  segment[kSegmentHeadBytes + 8] ^= std::byte{1};
  EXPECT_TRUE(scan_segment(segment, kSegment).records.empty());
}

TEST(Scan, a_record_at_the_wrong_offset_or_segment_is_damage) {
  const std::vector<std::size_t> lengths = {40, 40, 40};
  Bytes segment = segment_of(lengths);
  std::copy_n(segment.begin() + 16, 68, segment.begin() + 16 + 68);  // the first over the second
  const SegmentScan scan = scan_segment(segment, kSegment);
  ASSERT_EQ(scan.records.size(), 2U);
  EXPECT_EQ(scan.records[0].head.key.seq, 0U);
  EXPECT_EQ(scan.records[1].head.key.seq, 2U);
  EXPECT_TRUE(scan_segment(segment, kSegment + 1).records.empty()) << "another segment's file";
}

TEST(Scan, random_damage_never_creates_a_record_that_was_not_written) {
  const std::vector<std::size_t> lengths = {100, 3, 250, 0, 77, 31};
  const Bytes good = segment_of(lengths);
  Rng rng(1, "scan");
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = good;
    const int hits = 1 + static_cast<int>(rng.uniform() * 6.0);
    for (int k = 0; k < hits; ++k) {
      const auto at = static_cast<std::size_t>(rng.uniform() * static_cast<double>(bytes.size()));
      bytes[at] = static_cast<std::byte>(static_cast<unsigned>(rng.uniform() * 256.0));
    }
    if (rng.uniform() < 0.3) {
      bytes.resize(static_cast<std::size_t>(rng.uniform() * static_cast<double>(bytes.size())));
    }
    expect_only_written(bytes, scan_segment(bytes, kSegment), lengths, std::to_string(round));
  }
}

TEST(Scan, a_file_shorter_than_its_header_has_no_records) {
  for (std::size_t size = 0; size < kSegmentHeadBytes; ++size) {
    const SegmentScan scan = scan_segment(Bytes(size), kSegment);
    EXPECT_TRUE(scan.records.empty());
    EXPECT_EQ(scan.whole_end, 0U);
  }
}

}  // namespace
}  // namespace rali::factlog
