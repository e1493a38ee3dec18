#include "rali/wire/byte_reader.hpp"

#include <gtest/gtest.h>

#include "rali/wire/byte_writer.hpp"

namespace rali::wire {
namespace {

Bytes bytes_of(std::initializer_list<int> values) {
  Bytes bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

TEST(ByteReader, cdr_alignment_is_relative_to_the_end_of_its_header) {
  // uint8 7, 7 bytes of padding, float64 1.0: aligned to 8 from byte 4, so the double is at 12.
  const Bytes message =
      bytes_of({0, 1, 0, 0, 7, 9, 9, 9, 9, 9, 9, 9, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F});
  ByteReader in(message, Encoding::kCdr);
  EXPECT_EQ(in.get<std::uint8_t>(), 7);
  EXPECT_EQ(in.get<double>(), 1.0);
  EXPECT_TRUE(in.ok());
  EXPECT_EQ(in.remaining(), 0U);
}

TEST(ByteReader, xcdr2_aligns_doubles_to_four_bytes) {
  const Bytes message = bytes_of({0, 7, 0, 0, 7, 9, 9, 9, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F});
  ByteReader in(message, Encoding::kCdr);
  EXPECT_EQ(in.get<std::uint8_t>(), 7);
  EXPECT_EQ(in.get<double>(), 1.0);
}

TEST(ByteReader, big_endian_cdr_is_detected_from_its_header) {
  const Bytes message =
      bytes_of({0, 0, 0, 0, 0x12, 0x34, 9, 9, 0, 0, 0, 0, 0, 0, 0, 3, 'a', 'b', 0});
  ByteReader in(message, Encoding::kCdr);
  EXPECT_EQ(in.get<std::uint16_t>(), 0x1234);
  EXPECT_EQ(in.get<std::uint32_t>(), 0U);
  EXPECT_EQ(in.string(), "ab");
  EXPECT_TRUE(in.ok());
}

TEST(ByteReader, ros1_is_packed_and_its_strings_have_no_nul) {
  const Bytes message = bytes_of({7, 2, 0, 0, 0, 'h', 'i', 0xFF, 0xFF});
  ByteReader in(message, Encoding::kRos1);
  EXPECT_EQ(in.get<std::uint8_t>(), 7);
  EXPECT_EQ(in.string(), "hi");
  EXPECT_EQ(in.get<std::int16_t>(), -1);
  EXPECT_TRUE(in.ok());
}

TEST(ByteReader, stays_failed_after_reading_past_the_end) {
  const Bytes message = bytes_of({1, 2, 3});
  ByteReader in(message, Encoding::kRos1);
  EXPECT_EQ(in.get<std::uint32_t>(), 0U);
  EXPECT_FALSE(in.ok());
  EXPECT_EQ(in.get<std::uint8_t>(), 0);  // would fit, but the reader has already failed
  EXPECT_EQ(in.error("Imu").where, "byte 0");
  EXPECT_NE(in.error("Imu").what.find("Imu message of 3 bytes"), std::string::npos);
}

TEST(ByteReader, refuses_a_sequence_longer_than_the_message) {
  const Bytes message = bytes_of({0xFF, 0xFF, 0xFF, 0xFF, 1, 2});
  ByteReader in(message, Encoding::kRos1);
  EXPECT_EQ(in.sequence(1), 0U);
  EXPECT_FALSE(in.ok());
}

TEST(ByteReader, refuses_unknown_encapsulations_and_encodings) {
  EXPECT_FALSE(ByteReader(bytes_of({0, 3, 0, 0}), Encoding::kCdr).ok());  // PL_CDR
  EXPECT_FALSE(ByteReader(bytes_of({1, 0, 0, 0}), Encoding::kCdr).ok());
  EXPECT_FALSE(ByteReader(bytes_of({0, 1, 0}), Encoding::kCdr).ok());
  EXPECT_FALSE(ByteReader({}, Encoding::kCdr).ok());
  EXPECT_FALSE(ByteReader(bytes_of({0, 1, 0, 0}), Encoding::kOther).ok());
}

TEST(ByteReader, times_before_1970_survive_a_cdr_round_trip) {
  ByteWriter out(Encoding::kCdr);
  out.time(Time::from_ns(-1));
  const Bytes message = out.take();
  // -1 s and 999 999 999 ns
  EXPECT_EQ(message, bytes_of({0, 1, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xC9, 0x9A, 0x3B}));
  EXPECT_EQ(ByteReader(message, Encoding::kCdr).time().ns, -1);
}

TEST(ByteWriter, writes_what_the_reader_reads_in_all_encodings) {
  for (const Encoding encoding : {Encoding::kRos1, Encoding::kCdr}) {
    for (const bool big_endian : {false, true}) {
      ByteWriter out(encoding, big_endian);
      out.put(std::uint8_t{1});
      out.put(-2.5);
      out.string("abc");
      out.put(std::int64_t{-3});
      out.header(Time::from_ns(1'500'000'007), "imu");
      const Bytes message = out.take();
      ByteReader in(message, encoding);
      EXPECT_EQ(in.get<std::uint8_t>(), 1);
      EXPECT_EQ(in.get<double>(), -2.5);
      EXPECT_EQ(in.string(), "abc");
      EXPECT_EQ(in.get<std::int64_t>(), -3);
      const ByteReader::Header header = in.header();
      EXPECT_EQ(header.stamp.ns, 1'500'000'007);
      EXPECT_EQ(header.frame_id, "imu");
      EXPECT_TRUE(in.ok());
      EXPECT_EQ(in.remaining(), 0U);
    }
  }
}

}  // namespace
}  // namespace rali::wire
