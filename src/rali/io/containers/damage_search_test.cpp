#include "rali/io/containers/damage_search.hpp"

#include <gtest/gtest.h>

#include "rali/io/containers/bag_reader.hpp"
#include "rali/io/containers/bag_writer.hpp"
#include "rali/io/containers/mcap_reader.hpp"
#include "rali/io/containers/mcap_writer.hpp"
#include "rali/io/containers/testing.hpp"

namespace rali::io {
namespace {

using testing::drain;
using testing::Drained;
using testing::texts;

/// A file with appended zeros, as a hole or stored.
class GrownBytes final : public ByteSource {
 public:
  GrownBytes(std::vector<std::byte> bytes, std::uint64_t size, bool hole)
      : bytes_(std::move(bytes)), size_(size), hole_(hole) {}

  std::uint64_t size() const override { return size_; }

  const std::string& name() const override { return name_; }

  Status read(std::uint64_t offset, std::span<std::byte> out) override {
    read_ += out.size();
    for (std::size_t i = 0; i < out.size(); ++i, ++offset) {
      out[i] = offset < bytes_.size() ? bytes_[offset] : std::byte{0};
    }
    return {};
  }

  std::uint64_t next_data(std::uint64_t offset) override {
    return hole_ && offset >= bytes_.size() ? size_ : offset;
  }

  [[nodiscard]] std::uint64_t bytes_read() const { return read_; }

 private:
  std::vector<std::byte> bytes_;
  std::uint64_t size_;
  bool hole_;
  std::uint64_t read_ = 0;
  std::string name_ = "v1";
};

constexpr int kMessages = 40;

std::vector<std::byte> recording(bool bag, bool close_mcap = false) {
  MemorySink sink;
  const std::string data(1000, 'x');
  if (bag) {
    BagWriter writer(sink, {Compression::kNone, 4000});
    const auto imu = writer.add_connection("/imu", "sensor_msgs/Imu", "def", "u8 b");
    for (int i = 0; i < kMessages; ++i) {
      EXPECT_TRUE(writer.write(*imu, Time::from_s(1e9 + i), bytes_of(data)));
    }
    EXPECT_TRUE(writer.close());
    return sink.bytes();
  }
  McapWriter writer(sink, {"ros2", Compression::kNone, 4000});
  const auto imu = writer.add_channel(0, "/imu", "cdr");
  for (int i = 0; i < kMessages; ++i) {
    const Time t = Time::from_s(1e9 + i);
    EXPECT_TRUE(writer.write(*imu, t, t, bytes_of(data)));
  }
  EXPECT_TRUE(!close_mcap || writer.close());
  return sink.bytes();
}

Drained read(const std::shared_ptr<GrownBytes>& source, bool bag, const ReadLimits& limits = {}) {
  const auto opened = bag ? open_bag(source, limits) : open_mcap(source, limits);
  EXPECT_TRUE(opened) << (opened ? "" : opened.error().message());
  return opened ? drain(**opened) : Drained{};
}

TEST(DamageSearch, a_1_tb_hole_is_skipped_without_reading) {
  for (const bool bag : {true, false}) {
    const auto source = std::make_shared<GrownBytes>(recording(bag), 1ULL << 40, true);
    const Drained got = read(source, bag);
    EXPECT_GE(got.messages.size(), bag ? kMessages : kMessages - 4U);
    EXPECT_TRUE(got.health.truncated);
    EXPECT_NE(texts(got.health).find("nothing but zeros to the end, 1099511.6 MB"),
              std::string::npos)
        << texts(got.health);
    EXPECT_LT(source->bytes_read(), 8U << 20);
  }
}

TEST(DamageSearch, reports_bytes_after_the_end_of_a_complete_mcap) {
  const std::vector<std::byte> whole = recording(false, true);
  const auto grown = std::make_shared<GrownBytes>(whole, 1ULL << 40, true);
  const Drained got = read(grown, false);
  EXPECT_EQ(got.messages.size(), kMessages);
  EXPECT_EQ(got.health.messages_skipped, 0U);
  EXPECT_TRUE(got.health.truncated);
  EXPECT_EQ(got.health.bytes_lost, (1ULL << 40) - whole.size());
  EXPECT_NE(texts(got.health).find("nothing but zeros to the end, 1099511.6 MB"), std::string::npos)
      << texts(got.health);
  EXPECT_LT(grown->bytes_read(), 8U << 20);
  // Two recordings in one file: only the first is read.
  std::vector<std::byte> two = whole;
  two.insert(two.end(), whole.begin(), whole.end());
  const std::uint64_t size = two.size();
  const Drained first = read(std::make_shared<GrownBytes>(std::move(two), size, false), false);
  EXPECT_EQ(first.messages.size(), kMessages);
  EXPECT_EQ(first.health.bytes_lost, whole.size());
  EXPECT_NE(texts(first.health).find("behind the closing record were not read"), std::string::npos)
      << texts(first.health);
}

TEST(DamageSearch, stops_at_its_limit_in_random_bytes) {
  ReadLimits limits;
  limits.search_bytes = 4U << 20;
  for (const bool bag : {true, false}) {
    std::vector<std::byte> bytes = recording(bag);
    std::uint64_t noise = 1;
    for (int i = 0; i < (9 << 20); ++i) {
      noise = noise * 6364136223846793005ULL + 1442695040888963407ULL;
      bytes.push_back(static_cast<std::byte>(noise >> 56U));
    }
    const std::uint64_t size = bytes.size();
    const auto source = std::make_shared<GrownBytes>(std::move(bytes), size, false);
    const Drained got = read(source, bag, limits);
    EXPECT_GE(got.messages.size(), bag ? kMessages : kMessages - 4U);
    EXPECT_NE(texts(got.health).find("the rest of the file was not searched"), std::string::npos)
        << texts(got.health);
  }
}

TEST(DamageSearch, a_chunk_after_zeros_is_found) {
  for (const bool bag : {true, false}) {
    // The end of the recording follows 3 MB of zeros inserted in its middle.
    std::vector<std::byte> bytes = recording(bag);
    bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2), 3U << 20,
                 std::byte{0});
    const std::uint64_t size = bytes.size();
    const auto source = std::make_shared<GrownBytes>(std::move(bytes), size, false);
    EXPECT_GT(read(source, bag).messages.size(), kMessages / 2 + 8U);
  }
}

TEST(DamageSearch, holes_of_a_sparse_file_are_detected) {
  const testing::ScratchFolder scratch;
  const std::string path = scratch.path + "/grown.bag";
  testing::write_file(path, recording(true));
  std::filesystem::resize_file(path, 10ULL << 30);
  const auto source = open_file_bytes(path);
  ASSERT_TRUE(source);
  const std::uint64_t end = (*source)->next_data(1U << 20);
  if (end == 1U << 20) GTEST_SKIP() << "this file system does not know holes";
  EXPECT_EQ(end, 10ULL << 30);
  EXPECT_EQ((*source)->next_data(0), 0U);
}

}  // namespace
}  // namespace rali::io
