#include <filesystem>

#include <gtest/gtest.h>

#include "rali/io/containers/crc32.hpp"
#include "rali/io/containers/mcap_format.hpp"
#include "rali/io/containers/mcap_reader.hpp"
#include "rali/io/containers/mcap_writer.hpp"
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

/// Twelve messages of two topics, one second apart.
Written small_mcap(const McapWriter::Options& options, bool close = true) {
  MemorySink sink;
  McapWriter writer(sink, options);
  const auto cloud = writer.add_schema("sensor_msgs/msg/PointCloud2", "ros2msg", "uint8 a");
  const auto imu = writer.add_schema("sensor_msgs/msg/Imu", "ros2msg", "uint8 b");
  const auto points = writer.add_channel(*cloud, "/points", "cdr", {{"qos", "x"}});
  const auto inertial = writer.add_channel(*imu, "/imu", "cdr");
  Written out;
  for (int i = 0; i < 12; ++i) {
    const std::string data = "message " + std::to_string(i) + std::string(20, 'x');
    const Time t = Time::from_ns(kStart_ns + i * std::int64_t{1'000'000'000});
    EXPECT_TRUE(writer.write(i % 2 == 0 ? *points : *inertial, t, t, bytes_of(data)));
    out.messages.push_back({i % 2 == 0 ? "/points" : "/imu", t.ns, data});
  }
  if (close) {
    EXPECT_TRUE(writer.close());
  }
  out.bytes = sink.bytes();
  return out;
}

McapWriter::Options with(Compression compression, std::size_t chunk_bytes = 200) {
  return {"ros2", compression, chunk_bytes};
}

Drained read(std::vector<std::byte> bytes, const ReadLimits& limits = {}) {
  const auto source = open_mcap(memory_bytes(std::move(bytes), "v1.mcap"), limits);
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

TEST(Crc32, gives_the_check_value_of_its_standard_and_can_be_continued) {
  EXPECT_EQ(crc32(bytes_of("123456789")), 0xCBF43926U);
  EXPECT_EQ(crc32(bytes_of("6789"), crc32(bytes_of("12345"))), 0xCBF43926U);
  EXPECT_EQ(crc32({}), 0U);
}

struct Layout {
  std::string name;
  McapWriter::Options options;
};

class EachLayout : public ::testing::TestWithParam<Layout> {};

INSTANTIATE_TEST_SUITE_P(Mcap, EachLayout,
                         ::testing::Values(Layout{"none", with(Compression::kNone)},
                                           Layout{"lz4", with(Compression::kLz4)},
                                           Layout{"zstd", with(Compression::kZstd)},
                                           Layout{"chunkless", with(Compression::kNone, 0)}),
                         [](const auto& tested) { return tested.param.name; });

TEST_P(EachLayout, reads_back_the_written_messages_counts_and_time_span) {
  const Written written = small_mcap(GetParam().options);
  const auto source = open_mcap(memory_bytes(written.bytes, "v1.mcap"));
  ASSERT_TRUE(source);
  ASSERT_EQ((*source)->topics().size(), 2U);
  const Topic& topic = (*source)->topics()[0];
  EXPECT_EQ(topic.type, "sensor_msgs/msg/PointCloud2");
  EXPECT_EQ(topic.definition, "uint8 a");
  EXPECT_EQ(topic.encoding, wire::Encoding::kCdr);
  EXPECT_EQ(topic.messages, 6U);
  ASSERT_TRUE((*source)->span());
  EXPECT_EQ((*source)->span()->second - (*source)->span()->first, Duration::from_s(11.0));
  const std::string compression = GetParam().name == "chunkless" ? "none" : GetParam().name;
  EXPECT_EQ((*source)->health().compression, compression);
  const Drained got = drain(**source);
  EXPECT_EQ(got.messages, written.messages);
  EXPECT_EQ(got.health.messages, 12U);
  EXPECT_FALSE(got.health.truncated || got.health.unindexed);
  EXPECT_EQ(texts(got.health), "");
  EXPECT_EQ((*source)->progress(), 1.0);
}

TEST_P(EachLayout, writes_the_same_bytes_twice) {
  EXPECT_EQ(small_mcap(GetParam().options).bytes, small_mcap(GetParam().options).bytes);
}

TEST_P(EachLayout, lists_topics_of_an_unclosed_file_before_reading_messages) {
  McapWriter::Options options = GetParam().options;
  options.chunk_bytes = std::min<std::size_t>(options.chunk_bytes, 1);
  const Written written = small_mcap(options, /*close=*/false);
  const auto source = open_mcap(memory_bytes(written.bytes, "v1.mcap"));
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->topics().size(), 2U);
  const Drained got = drain(**source);
  EXPECT_EQ(got.messages, written.messages);
  EXPECT_TRUE(got.health.unindexed && got.health.truncated);
}

TEST_P(EachLayout, truncated_at_any_byte_gives_a_prefix_and_reports_a_missing_index) {
  const Written written = small_mcap(GetParam().options);
  std::size_t maximum = 0;
  for (std::size_t n = kMcapMagic.size(); n < written.bytes.size(); ++n) {
    const Drained got = read(first(written.bytes, n));
    ASSERT_EQ(got.error, "") << n;
    ASSERT_TRUE(is_prefix(got.messages, written.messages)) << n;
    ASSERT_GE(got.messages.size(), maximum) << n << ": a longer file gave fewer messages";
    maximum = got.messages.size();
    ASSERT_EQ(got.health.messages_skipped, 0U) << n << texts(got.health);
    ASSERT_TRUE(got.health.unindexed) << n;
  }
  EXPECT_EQ(maximum, 12U);
}

// Without chunks there is no checksum, so only the chunked layouts guarantee this.
TEST(Mcap, a_flipped_byte_in_a_chunk_is_never_returned_as_data) {
  for (const Compression compression :
       {Compression::kNone, Compression::kLz4, Compression::kZstd}) {
    const Written written = small_mcap(with(compression));
    for (std::size_t i = kMcapMagic.size(); i < written.bytes.size(); ++i) {
      std::vector<std::byte> bytes = written.bytes;
      bytes[i] ^= std::byte{0x41};
      const Drained got = read(std::move(bytes));
      for (const Got& message : got.messages) {
        const auto known = std::find(written.messages.begin(), written.messages.end(), message);
        ASSERT_NE(known, written.messages.end()) << i;
      }
      ASSERT_TRUE(got.messages.size() == 12 || !got.health.findings.empty())
          << i << ": messages went missing in silence";
    }
  }
}

TEST(Mcap, a_wrong_checksum_loses_its_chunk_and_counts_its_messages) {
  Written written = small_mcap(with(Compression::kNone));
  written.bytes[find_text(written.bytes, "message 5x")] ^= std::byte{1};
  const Drained got = read(written.bytes);
  EXPECT_EQ(got.messages.size() + got.health.messages_skipped, 12U);
  EXPECT_GT(got.health.messages_skipped, 1U);
  EXPECT_NE(texts(got.health).find("checksum"), std::string::npos) << texts(got.health);
}

TEST(Mcap, complete_messages_of_a_truncated_uncompressed_chunk_are_returned) {
  const Written written = small_mcap(with(Compression::kNone, 1'000'000));
  const Drained got = read(first(written.bytes, find_text(written.bytes, "message 7x")));
  EXPECT_EQ(got.messages.size(), 7U);
  EXPECT_NE(texts(got.health).find(": record ends after the file. Read 6.0 s."), std::string::npos)
      << texts(got.health);
  EXPECT_LT(got.health.bytes_lost, 100U);
}

TEST(Mcap, a_wrong_chunk_length_is_skipped_to_the_next_chunk) {
  for (const Compression compression : {Compression::kNone, Compression::kZstd}) {
    Written written = small_mcap(with(compression));
    std::size_t chunk = 0;
    // Finds the first chunk record: its opcode is followed by a length below 256.
    for (std::size_t i = 9; chunk == 0; ++i) {
      if (written.bytes[i] == std::byte{6} && written.bytes[i + 2] == std::byte{0} &&
          written.bytes[i + 8] == std::byte{0}) {
        chunk = i;
      }
    }
    written.bytes[chunk + 8] = std::byte{0x40};  // 2^62 bytes
    const Drained got = read(written.bytes);
    EXPECT_EQ(got.messages, written.messages) << texts(got.health);
    EXPECT_FALSE(got.health.findings.empty());
  }
}

/// An MCAP of one chunk with a header as given.
std::vector<std::byte> one_chunk(std::uint64_t uncompressed_bytes, std::string_view compression,
                                 std::uint64_t record_bytes, std::string_view records) {
  std::vector<std::byte> content;
  Appender append(content);
  append.u64(0);
  append.u64(0);
  append.u64(uncompressed_bytes);
  append.u32(0);
  append.text32(compression);
  append.u64(record_bytes);
  append.text(records);
  std::vector<std::byte> bytes = copy(kMcapMagic);
  Appender out(bytes);
  out.u8(6);
  out.u64(content.size());
  out.bytes(content);
  return bytes;
}

TEST(Mcap, a_chunk_with_a_1_tb_header_size_is_refused_without_allocation) {
  const Drained got = read(one_chunk(1ULL << 40, "zstd", 4, "abcd"));
  EXPECT_EQ(got.health.messages_skipped, 1U);
  EXPECT_NE(texts(got.health).find("1099511627776 bytes is larger than the 1073741824"),
            std::string::npos)
      << texts(got.health);
}

TEST(Mcap, unknown_compression_is_named) {
  EXPECT_NE(texts(read(one_chunk(4, "brotli", 4, "abcd")).health).find("'brotli'"),
            std::string::npos);
}

TEST(Mcap, an_empty_recording_has_no_messages_and_no_findings) {
  MemorySink sink;
  McapWriter writer(sink, with(Compression::kZstd));
  ASSERT_TRUE(writer.close());
  const Drained got = read(sink.bytes());
  EXPECT_EQ(got.error, "");
  EXPECT_TRUE(got.messages.empty());
  EXPECT_EQ(texts(got.health), "");
}

TEST(Mcap, the_writer_refuses_what_the_format_cannot_hold) {
  MemorySink sink;
  McapWriter writer(sink, with(Compression::kZstd));
  EXPECT_FALSE(writer.add_channel(7, "/t", "cdr"));
  EXPECT_FALSE(writer.write(0, Time{}, Time{}, {}));
  const auto channel = writer.add_channel(0, "/t", "json");
  ASSERT_TRUE(channel);
  EXPECT_FALSE(writer.write(*channel, Time::from_ns(-1), Time{}, {}));
  EXPECT_TRUE(writer.write(*channel, Time{}, Time{}, {}));
  ASSERT_TRUE(writer.close());
  EXPECT_FALSE(writer.write(*channel, Time{}, Time{}, {}));
}

/// One message per second, each in its own chunk, at these seconds.
std::optional<bool> in_order(const std::vector<int>& seconds, bool close = true) {
  MemorySink sink;
  McapWriter::Options options = with(Compression::kNone);
  options.chunk_bytes = 1;
  McapWriter writer(sink, options);
  const auto channel = writer.add_channel(0, "/t", "json");
  for (const int s : seconds) {
    const Time t = Time::from_s(1e9 + s);
    EXPECT_TRUE(writer.write(*channel, t, t, bytes_of("x")));
  }
  if (close) {
    EXPECT_TRUE(writer.close());
  }
  const auto source = open_mcap(memory_bytes(sink.bytes(), "v1.mcap"));
  EXPECT_TRUE(source);
  return (*source)->in_order();
}

TEST(Mcap, the_index_shows_whether_the_chunks_are_in_time_order) {
  EXPECT_EQ(in_order({0, 1, 2, 3}), true);
  EXPECT_EQ(in_order({3, 2, 1, 0}), false);
  EXPECT_EQ(in_order({0, 1, 3, 2}), false);
  EXPECT_EQ(in_order({}), true);
  EXPECT_EQ(in_order({0, 1, 2}, false), std::nullopt) << "no index: it has to be read";
}

TEST(Mcap, real_recordings_have_three_clouds_in_every_layout) {
  const std::string folder = std::string(RALI_DATA_DIR) + "/recordings/converted_pointcloud2/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no data pack at " << folder;
  for (const std::string name : {"none", "lz4", "zstd", "nochunk"}) {
    const auto file = open_file_bytes(folder + "kitti16_3scans_" + name + ".mcap");
    ASSERT_TRUE(file);
    const auto source = open_mcap(*file);
    ASSERT_TRUE(source);
    ASSERT_EQ((*source)->topics().size(), 1U);
    EXPECT_EQ((*source)->topics()[0].messages, 3U) << name;
    std::size_t bytes = 0;
    RawMessage message;
    while ((*source)->next(message).value_or(false)) bytes += message.data.size();
    EXPECT_EQ(bytes, 2'065'213U) << name;
    EXPECT_EQ(texts((*source)->health()), "") << name;
    EXPECT_EQ((*source)->health().compression, name == "nochunk" ? "none" : name);
  }
}

}  // namespace
}  // namespace rali::io
