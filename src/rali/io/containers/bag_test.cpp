#include <filesystem>

#include <gtest/gtest.h>

#include "rali/io/containers/bag_format.hpp"
#include "rali/io/containers/bag_reader.hpp"
#include "rali/io/containers/bag_writer.hpp"
#include "rali/io/containers/testing.hpp"

namespace rali::io {
namespace {

using testing::copy;
using testing::drain;
using testing::Drained;
using testing::first;
using testing::Got;
using testing::is_prefix;
using testing::texts;

constexpr std::int64_t kStart_ns = 1'600'000'000'000'000'000;

struct Written {
  std::vector<std::byte> bytes;
  std::vector<Got> messages;
};

/// Twelve messages of two topics, one second apart, in small chunks.
Written small_bag(Compression compression, bool close = true, std::size_t chunk_bytes = 300) {
  MemorySink sink;
  BagWriter writer(sink, {compression, chunk_bytes});
  const auto lidar = writer.add_connection("/points", "sensor_msgs/PointCloud2", "abc", "u8 a");
  const auto imu = writer.add_connection("/imu", "sensor_msgs/Imu", "def", "u8 b");
  Written out;
  for (int i = 0; i < 12; ++i) {
    const std::string data = "message " + std::to_string(i) + std::string(20, 'x');
    const Time t = Time::from_ns(kStart_ns + i * std::int64_t{1'000'000'000});
    EXPECT_TRUE(writer.write(i % 2 == 0 ? *lidar : *imu, t, bytes_of(data)));
    out.messages.push_back({i % 2 == 0 ? "/points" : "/imu", t.ns, data});
  }
  if (close) {
    EXPECT_TRUE(writer.close());
  }
  out.bytes = sink.bytes();
  return out;
}

Drained read(std::vector<std::byte> bytes, const ReadLimits& limits = {}) {
  const auto source = open_bag(memory_bytes(std::move(bytes), "v1.bag"), limits);
  if (!source) {
    Drained out;
    out.error = source.error().message();
    return out;
  }
  return drain(**source);
}

std::size_t find_text(const std::vector<std::byte>& bytes, std::string_view text,
                      std::size_t from = 0) {
  return text_of(bytes).find(text, from);
}

class EachCompression : public ::testing::TestWithParam<Compression> {};

INSTANTIATE_TEST_SUITE_P(Bag, EachCompression,
                         ::testing::Values(Compression::kNone, Compression::kLz4,
                                           Compression::kBz2),
                         [](const auto& tested) { return std::string(name_of(tested.param)); });

TEST_P(EachCompression, reads_back_the_written_messages_counts_and_time_span) {
  const Written written = small_bag(GetParam());
  const auto source = open_bag(memory_bytes(written.bytes, "v1.bag"));
  ASSERT_TRUE(source);
  ASSERT_EQ((*source)->topics().size(), 2U);
  EXPECT_EQ((*source)->topics()[0].type, "sensor_msgs/PointCloud2");
  EXPECT_EQ((*source)->topics()[0].definition, "u8 a");
  EXPECT_EQ((*source)->topics()[0].messages, 6U);
  EXPECT_EQ((*source)->topics()[1].messages, 6U);
  ASSERT_TRUE((*source)->span());
  EXPECT_EQ((*source)->span()->second - (*source)->span()->first, Duration::from_s(11.0));
  const Drained got = drain(**source);
  EXPECT_EQ(got.messages, written.messages);
  EXPECT_EQ(got.health.messages, 12U);
  EXPECT_EQ(got.health.messages_skipped, 0U);
  EXPECT_EQ(got.health.compression, name_of(GetParam()));
  EXPECT_FALSE(got.health.truncated || got.health.unindexed);
  EXPECT_EQ(texts(got.health), "");
  EXPECT_EQ((*source)->progress(), 1.0);
}

TEST_P(EachCompression, writes_the_same_bytes_twice) {
  EXPECT_EQ(small_bag(GetParam()).bytes, small_bag(GetParam()).bytes);
}

TEST_P(EachCompression, reads_a_bag_that_was_never_closed) {
  const Written written = small_bag(GetParam(), /*close=*/false, /*chunk_bytes=*/1);
  const Drained got = read(written.bytes);
  EXPECT_EQ(got.messages, written.messages);
  EXPECT_TRUE(got.health.unindexed);
  EXPECT_FALSE(got.health.truncated);
}

TEST_P(EachCompression, truncated_at_any_byte_gives_a_prefix_and_reports_truncation) {
  const Written written = small_bag(GetParam());
  std::size_t maximum = 0;
  for (std::size_t n = kBagMagic.size(); n < written.bytes.size(); ++n) {
    const Drained got = read(first(written.bytes, n));
    ASSERT_EQ(got.error, "") << n;
    ASSERT_TRUE(is_prefix(got.messages, written.messages)) << n;
    ASSERT_GE(got.messages.size(), maximum) << n << ": a longer file gave fewer messages";
    maximum = got.messages.size();
    ASSERT_EQ(got.health.messages_skipped, 0U) << n;
    // Within the first record a missing end cannot be detected yet.
    ASSERT_TRUE(got.health.truncated || n < 5000) << n;
  }
  EXPECT_EQ(maximum, 12U);
}

TEST_P(EachCompression, a_flipped_byte_never_invents_or_repeats_messages) {
  const Written written = small_bag(GetParam());
  for (std::size_t i = 0; i < written.bytes.size(); ++i) {
    if (i > 100 && i < 4100) continue;  // padding
    std::vector<std::byte> bytes = written.bytes;
    bytes[i] ^= std::byte{0x41};
    const Drained got = read(std::move(bytes));
    ASSERT_LE(got.messages.size(), 12U) << i;
  }
}

TEST(Bag, a_truncated_file_reports_the_time_span_read) {
  // Without compression, every whole record of the truncated chunk is returned.
  const Written written = small_bag(Compression::kNone, true, 1'000'000);
  const std::size_t seventh = find_text(written.bytes, "message 6");
  const Drained got = read(first(written.bytes, seventh + 4));
  EXPECT_EQ(got.messages.size(), 6U);
  EXPECT_TRUE(got.health.truncated);
  ASSERT_FALSE(got.health.findings.empty());
  const std::string text = got.health.findings.back().text;
  EXPECT_TRUE(text.starts_with("v1.bag:offset ")) << text;
  EXPECT_NE(text.find(": record ends after the file. Read 5.0 of about "), std::string::npos)
      << text;
  EXPECT_GT(got.health.bytes_lost, 0U);
  EXPECT_LT(got.health.bytes_lost, 200U);
}

TEST(Bag, only_selected_topics_are_returned) {
  const Written written = small_bag(Compression::kLz4);
  const auto source = open_bag(memory_bytes(written.bytes, "v1.bag"));
  ASSERT_TRUE(source);
  (*source)->select([](const Topic& topic) { return topic.type == "sensor_msgs/Imu"; });
  const Drained got = drain(**source);
  EXPECT_EQ(got.messages.size(), 6U);
  for (const Got& message : got.messages) EXPECT_EQ(message.topic, "/imu");
}

TEST(Bag, damage_in_one_compressed_chunk_loses_only_that_chunk) {
  Written written = small_bag(Compression::kBz2);
  const std::size_t second = find_text(written.bytes, "BZh", find_text(written.bytes, "BZh") + 1);
  written.bytes[second + 30] ^= std::byte{0xFF};
  const Drained got = read(written.bytes);
  EXPECT_EQ(got.messages.size() + got.health.messages_skipped, 12U);
  EXPECT_GT(got.health.messages_skipped, 0U);
  EXPECT_LT(got.health.messages_skipped, 6U);
  EXPECT_NE(texts(got.health).find("bz2"), std::string::npos) << texts(got.health);
}

TEST(Bag, a_wrong_record_length_is_skipped_to_the_next_chunk) {
  Written written = small_bag(Compression::kLz4);
  const std::size_t mark = find_text(written.bytes, "compression=lz4");
  const std::size_t length = find_text(written.bytes, "\x04\x22\x4d\x18", mark) - 4;
  written.bytes[length + 3] = std::byte{0xF0};  // about 4 GiB
  const Drained got = read(written.bytes);
  EXPECT_EQ(got.messages, written.messages) << texts(got.health);
  EXPECT_FALSE(got.health.truncated);
  EXPECT_FALSE(got.health.findings.empty());
}

TEST(Bag, a_message_longer_than_its_chunk_loses_the_rest_of_it) {
  Written written = small_bag(Compression::kNone);
  const std::size_t text = find_text(written.bytes, "message 1x");
  written.bytes[text - 1] = std::byte{0x7F};
  const Drained got = read(written.bytes);
  EXPECT_EQ(got.messages.size() + got.health.messages_skipped, 12U) << texts(got.health);
  EXPECT_GT(got.health.messages_skipped, 0U);
  EXPECT_EQ(got.messages.back().data, written.messages.back().data);
}

TEST(Bag, a_chunk_larger_than_the_limit_is_refused_with_both_sizes) {
  ReadLimits limits;
  limits.chunk_bytes = 100;
  const Drained got = read(small_bag(Compression::kLz4).bytes, limits);
  EXPECT_TRUE(got.messages.empty());
  EXPECT_EQ(got.health.messages_skipped, 12U);
  EXPECT_NE(texts(got.health).find("larger than the 100 that are accepted"), std::string::npos);
}

TEST(Bag, older_formats_and_encrypted_bags_are_refused_with_a_reason) {
  EXPECT_NE(read(copy("#ROSBAG V1.2\nrubbish")).error.find("rosbag fix"), std::string::npos);
  std::vector<std::byte> bytes = copy(kBagMagic);
  std::vector<std::byte> fields;
  Appender append(fields);
  append.text32(std::string_view("op=\x03", 4));
  append.text32("encryptor=rosbag/AesCbcEncryptor");
  Appender out(bytes);
  out.u32(static_cast<std::uint32_t>(fields.size()));
  out.bytes(fields);
  out.u32(0);
  EXPECT_NE(read(bytes).error.find("encrypted bag (rosbag/AesCbcEncryptor)"), std::string::npos);
}

struct RealBag {
  std::string file;
  std::string compression;
  std::size_t topics;
  std::uint64_t messages;
};

TEST(Bag, real_recordings_have_the_messages_their_readme_lists) {
  const std::string folder = std::string(RALI_DATA_DIR) + "/recordings/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no data pack at " << folder;
  const RealBag bags[] = {
      {"converted_pointcloud2/kitti16_3scans_none.bag", "none", 1, 3},
      {"converted_pointcloud2/kitti16_3scans_lz4.bag", "lz4", 1, 3},
      {"converted_pointcloud2/kitti16_3scans_bz2.bag", "bz2", 1, 3},
      {"ouster/512x10_raw.bag", "none", 3, 43},
      {"tiers_uwb/TAG_2_flight06.bag", "none", 7, 3 * 656 + 644 + 2 * 656 + 3250},
      {"tiers_uwb/TAG_2_flight09.bag", "none", 7, 4152},
      {"tiers_uwb/TAG_2_flight01.bag", "none", 7, 3 * 2140 + 2099 + 2 * 2140 + 10143}};
  for (const RealBag& bag : bags) {
    const auto file = open_file_bytes(folder + bag.file);
    ASSERT_TRUE(file);
    const auto source = open_bag(*file);
    ASSERT_TRUE(source) << source.error().message();
    EXPECT_EQ((*source)->topics().size(), bag.topics) << bag.file;
    std::uint64_t promised = 0;
    for (const Topic& topic : (*source)->topics()) promised += topic.messages.value_or(0);
    RawMessage message;
    while ((*source)->next(message).value_or(false)) {
    }
    EXPECT_EQ((*source)->health().messages, bag.messages) << bag.file;
    EXPECT_EQ(promised, bag.messages) << bag.file;
    EXPECT_EQ((*source)->health().compression, bag.compression) << bag.file;
    EXPECT_EQ(texts((*source)->health()), "") << bag.file;
  }
}

TEST(Bag, the_index_shows_whether_the_chunks_are_in_time_order) {
  for (const bool back : {false, true}) {
    MemorySink sink;
    BagWriter writer(sink, {Compression::kNone, 1});
    const auto imu = writer.add_connection("/imu", "sensor_msgs/Imu", "def", "u8 b");
    for (int i = 0; i < 5; ++i) {
      const Time t = Time::from_s(1e9 + (back ? 5 - i : i));
      EXPECT_TRUE(writer.write(*imu, t, bytes_of("x")));
    }
    ASSERT_TRUE(writer.close());
    const auto source = open_bag(memory_bytes(sink.bytes(), "v1.bag"));
    ASSERT_TRUE(source);
    EXPECT_EQ((*source)->in_order(), !back);
  }
  const Written open = small_bag(Compression::kNone, false);
  EXPECT_EQ((*open_bag(memory_bytes(open.bytes, "v1.bag")))->in_order(), std::nullopt);
}

}  // namespace
}  // namespace rali::io
