#include <filesystem>
#include <fstream>
#include <set>

#include <gtest/gtest.h>

#include "rali/io/containers/codec.hpp"
#include "rali/io/containers/db3_reader.hpp"
#include "rali/io/containers/db3_writer.hpp"
#include "rali/io/containers/testing.hpp"

namespace rali::io {
namespace {

namespace fs = std::filesystem;

using testing::copy;
using testing::drain;
using testing::Drained;
using testing::first;
using testing::Got;
using testing::ScratchFolder;
using testing::texts;

constexpr std::int64_t kStart_ns = 1'600'000'000'000'000'000;

struct Written {
  std::vector<std::byte> bytes;  ///< of the .db3
  std::vector<Got> messages;
};

/// Messages of two topics, written out of order in time; `each` converts text to the stored bytes.
Written small_db3(int messages, std::size_t extra_bytes,
                  const std::function<std::vector<std::byte>(std::string)>& each = {}) {
  ScratchFolder scratch;
  auto writer = Db3Writer::create(scratch.path + "/bag");
  EXPECT_TRUE(writer);
  const auto points = (*writer)->add_topic("/points", "sensor_msgs/msg/PointCloud2");
  const auto imu = (*writer)->add_topic("/imu", "sensor_msgs/msg/Imu");
  Written out;
  out.messages.resize(static_cast<std::size_t>(messages));
  for (int i = 0; i < messages; ++i) {
    const int order = i ^ 1;  // neighbours swapped
    const std::string data = "message " + std::to_string(order) +
                             std::string(extra_bytes, static_cast<char>('a' + i % 26));
    const Time t = Time::from_ns(kStart_ns + order * std::int64_t{1'000'000'000});
    const auto stored = each ? each(data) : copy(data);
    EXPECT_TRUE((*writer)->write(order % 2 == 0 ? *points : *imu, t, stored));
    out.messages[static_cast<std::size_t>(order)] = {order % 2 == 0 ? "/points" : "/imu", t.ns,
                                                     data};
  }
  EXPECT_TRUE((*writer)->close());
  out.bytes = testing::read_file((*writer)->database_path());
  return out;
}

Result<std::unique_ptr<MessageSource>> open(const std::vector<std::byte>& bytes,
                                            const Db3Hints& hints = {}) {
  auto database = SqlDatabase::open_bytes(bytes, 1U << 30);
  if (!database) return tl::make_unexpected(database.error());
  return open_db3(std::move(*database), "v1.db3", bytes.size(), hints);
}

Drained read(const std::vector<std::byte>& bytes, const Db3Hints& hints = {}) {
  const auto source = open(bytes, hints);
  if (source) return drain(**source);
  Drained out;
  out.error = source.error().message();
  return out;
}

TEST(Db3, reads_back_the_written_messages_in_time_order) {
  const Written written = small_db3(12, 20);
  const auto source = open(written.bytes);
  ASSERT_TRUE(source) << source.error().message();
  ASSERT_EQ((*source)->topics().size(), 2U);
  EXPECT_EQ((*source)->topics()[0].name, "/points");
  EXPECT_EQ((*source)->topics()[0].type, "sensor_msgs/msg/PointCloud2");
  EXPECT_EQ((*source)->topics()[0].encoding, wire::Encoding::kCdr);
  EXPECT_EQ((*source)->topics()[1].messages, 6U);
  ASSERT_TRUE((*source)->span());
  EXPECT_EQ((*source)->span()->second - (*source)->span()->first, Duration::from_s(11.0));
  const Drained got = drain(**source);
  EXPECT_EQ(got.messages, written.messages);
  EXPECT_EQ(got.health.messages, 12U);
  EXPECT_EQ(got.health.compression, "none");
  EXPECT_EQ(texts(got.health), "");
  EXPECT_EQ((*source)->progress(), 1.0);
}

TEST(Db3, writes_the_same_bytes_twice) {
  EXPECT_EQ(small_db3(12, 500).bytes, small_db3(12, 500).bytes);
}

TEST(Db3, only_selected_topics_are_returned) {
  const auto source = open(small_db3(12, 20).bytes);
  ASSERT_TRUE(source);
  (*source)->select([](const Topic& topic) { return topic.name == "/imu"; });
  EXPECT_EQ(drain(**source).messages.size(), 6U);
}

TEST(Db3, messages_compressed_individually_are_recognised_without_metadata) {
  const Written written = small_db3(
      12, 300, [](const std::string& data) { return *compress(Compression::kZstd, copy(data)); });
  const Drained got = read(written.bytes);
  EXPECT_EQ(got.messages, written.messages);
  EXPECT_EQ(got.health.compression, "zstd");
}

TEST(Db3, a_damaged_compressed_message_loses_only_itself) {
  int n = 0;
  const Written written = small_db3(12, 300, [&n](const std::string& data) {
    auto packed = *compress(Compression::kZstd, copy(data));
    if (++n == 5) packed.resize(packed.size() - 3);
    return packed;
  });
  const Drained got = read(written.bytes);
  EXPECT_EQ(got.messages.size(), 11U);
  EXPECT_EQ(got.health.messages_skipped, 1U);
  EXPECT_NE(texts(got.health).find("row 5"), std::string::npos) << texts(got.health);
}

TEST(Db3, truncated_at_any_page_gives_only_written_messages_and_one_finding) {
  const Written written = small_db3(60, 1500);
  std::size_t maximum = 0;
  for (std::size_t n = 0; n < written.bytes.size(); n += 512) {
    const Drained got = read(first(written.bytes, n));
    std::set<std::int64_t> times;
    for (const Got& message : got.messages) {
      ASSERT_TRUE(times.insert(message.t_ns).second) << n << ": a message twice";
      ASSERT_NE(std::find(written.messages.begin(), written.messages.end(), message),
                written.messages.end())
          << n << ": a message that was not written";
    }
    if (got.error.empty()) {
      ASSERT_EQ(got.health.findings.size(), 1U) << n << texts(got.health);
    }
    maximum = std::max(maximum, got.messages.size());
  }
  EXPECT_GT(maximum, 30U) << "a file that is cut near its end must give most of its messages";
}

TEST(Db3, damaged_pages_in_the_middle_lose_only_their_rows) {
  const Written written = small_db3(60, 1500);
  std::vector<std::byte> bytes = written.bytes;
  const std::size_t hit = text_of(bytes).find("message 30") / 4096 * 4096;
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(hit), 100, std::byte{0xEE});
  const Drained got = read(bytes);
  EXPECT_EQ(got.error, "");
  EXPECT_GT(got.messages.size(), 50U) << texts(got.health);
  EXPECT_LT(got.messages.size(), 60U);
  EXPECT_EQ(got.messages.size() + got.health.messages_skipped, 60U);
  EXPECT_EQ(got.health.findings.size(), 1U) << texts(got.health);
}

TEST(Db3, flipped_bytes_never_crash_the_reader) {
  const Written written = small_db3(12, 20);
  for (std::size_t i = 0; i < written.bytes.size(); i += 97) {
    std::vector<std::byte> bytes = written.bytes;
    bytes[i] ^= std::byte{0x81};
    const Drained got = read(bytes);
    ASSERT_LE(got.messages.size(), 24U) << i;
  }
}

TEST(Db3, a_database_without_rosbag2_tables_is_refused) {
  ScratchFolder scratch;
  {
    auto database = SqlDatabase::create(scratch.path + "/x.db");
    ASSERT_TRUE(database);
    ASSERT_TRUE(database->run("CREATE TABLE songs(id INTEGER)"));
  }
  const Drained got = read(testing::read_file(scratch.path + "/x.db"));
  EXPECT_NE(got.error.find("without the tables 'topics' and 'messages'"), std::string::npos);
}

TEST(Db3, a_view_instead_of_the_messages_table_is_refused) {
  ScratchFolder scratch;
  {
    auto database = SqlDatabase::create(scratch.path + "/x.db");
    ASSERT_TRUE(database);
    ASSERT_TRUE(database->run(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format);"
        "CREATE VIEW messages AS WITH RECURSIVE c(rowid) AS (SELECT 1 UNION ALL SELECT rowid + 1 "
        "FROM c) SELECT rowid, 1 AS topic_id, rowid AS timestamp, 'x' AS data FROM c;"));
  }
  EXPECT_NE(read(testing::read_file(scratch.path + "/x.db")).error, "");
}

TEST(Db3, messages_in_the_write_ahead_log_of_a_killed_recorder_are_read) {
  ScratchFolder scratch;
  const std::string path = scratch.path + "/x.db3";
  auto recorder = SqlDatabase::create(path);
  ASSERT_TRUE(recorder);
  ASSERT_TRUE(
      recorder->run("PRAGMA journal_mode=WAL; PRAGMA wal_autocheckpoint=0;"
                    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format);"
                    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data);"
                    "INSERT INTO topics VALUES (1, '/t', 'x', 'cdr');"
                    "INSERT INTO messages VALUES (1, 1, 5, 'one');"));
  // As a killed recorder leaves it: the log next to the file, none of it in the file yet.
  fs::create_directory(scratch.path + "/left");
  fs::copy_file(path, scratch.path + "/left/x.db3");
  fs::copy_file(path + "-wal", scratch.path + "/left/x.db3-wal");
  const auto source = open_recording(scratch.path + "/left/x.db3");
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ(drain(**source).messages, (std::vector<Got>{{"/t", 5, "one"}}));
}

TEST(Db3, a_truncated_file_on_disk_is_read_like_one_in_memory) {
  ScratchFolder scratch;
  const Written written = small_db3(60, 1500);
  const auto cut = first(written.bytes, written.bytes.size() - 1000);
  testing::write_file(scratch.path + "/x.db3", cut);
  const auto source = open_recording(scratch.path + "/x.db3");
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ(drain(**source).messages, read(cut).messages);
}

TEST(Db3, the_writer_refuses_a_folder_that_holds_something) {
  ScratchFolder scratch;
  std::ofstream(scratch.path + "/file") << "x";
  EXPECT_FALSE(Db3Writer::create(scratch.path));
}

}  // namespace
}  // namespace rali::io
