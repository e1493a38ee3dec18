#include "rali/inspect/info.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/drive/hall_recording_for_test.hpp"

namespace rali::inspect {
namespace {

namespace fs = std::filesystem;

std::string temporary(const std::string& name) {
  return (fs::path(testing::TempDir()) / name).string();
}

TEST(Info, names_topics_rates_fields_offsets_and_values) {
  drive::test::HallRecording recording;
  recording.duration_s = 1.0;
  const std::string path = recording.write(temporary("info_hall.bag"));
  const auto info = look_into(path);
  fs::remove(path);
  ASSERT_TRUE(info.has_value()) << info.error().message();
  ASSERT_EQ(info->topics.size(), 2U);
  EXPECT_EQ(info->topics[1].name, "/imu/data");
  EXPECT_EQ(info->topics[1].messages, 200U);
  EXPECT_NEAR(info->topics[1].rate_hz, 200.0, 0.5);
  ASSERT_TRUE(info->cloud.has_value());
  EXPECT_EQ(info->cloud->point_step, 22U);
  ASSERT_EQ(info->cloud->fields.size(), 6U);
  EXPECT_EQ(info->cloud->fields[4].name, "ring");
  EXPECT_EQ(info->cloud->fields[4].offset, 16U);
  EXPECT_EQ(info->cloud->fields[4].high, 15.0);
  const auto json = nlohmann::json::parse(info_json(*info));
  EXPECT_EQ(json["cloud"]["fields"][5]["name"], "time");
  EXPECT_NE(info_text(*info).find("sensor_msgs/PointCloud2"), std::string::npos);
}

TEST(Info, a_bag_truncated_at_any_offset_is_read_or_refused) {
  drive::test::HallRecording recording;
  recording.duration_s = 0.2;
  const std::string path = recording.write(temporary("info_cut.bag"));
  const auto size = fs::file_size(path);
  for (int part = 19; part >= 0; --part) {
    fs::resize_file(path, size * static_cast<std::uintmax_t>(part) / 20);
    const auto info = look_into(path);
    const bool reported = info ? !info_text(*info).empty() : !info.error().what.empty();
    EXPECT_TRUE(reported) << part;
  }
  fs::remove(path);
}

TEST(Info, invalid_files_give_information_or_an_error_message) {
  const std::string path = temporary("info_rubbish.bin");
  for (const std::string& content :
       {std::string(), std::string("hello\n"), std::string(1000, '\xff'),
        std::string("#ROSBAG V2.0\n"), std::string("\x89MCAP0\r\n")}) {
    std::ofstream(path, std::ios::binary) << content;
    const auto info = look_into(path);
    if (!info) {
      EXPECT_FALSE(info.error().what.empty());
    } else {
      EXPECT_FALSE(info_text(*info).empty());
    }
  }
  fs::remove(path);
  EXPECT_FALSE(look_into("/nonexistent").has_value());
}

TEST(Info, field_offsets_outside_the_point_are_not_read) {
  wire::CloudView view;
  view.width = 3;
  view.height = 1;
  view.point_step = 4;
  view.row_step = 12;
  view.fields = {{"x", 0xfffffff0U, wire::FieldType::kFloat64, 1}};
  const std::vector<std::byte> data(12);
  view.data = data;
  const std::string path = temporary("info_hostile.bag");
  io::MemorySink sink;
  io::BagWriter bag(sink, io::BagWriter::Options{});
  const auto clouds = drive::test::connect(bag, "/points", "sensor_msgs/PointCloud2");
  ASSERT_TRUE(bag.write(clouds, Time::from_s(1.0), wire::encode(view, wire::Encoding::kRos1)));
  ASSERT_TRUE(bag.close().has_value());
  ASSERT_TRUE(io::write_file_atomic(path, std::span<const std::byte>(sink.bytes())).has_value());
  const auto info = look_into(path);
  fs::remove(path);
  ASSERT_TRUE(info.has_value());
  ASSERT_TRUE(info->cloud.has_value());
  EXPECT_FALSE(info->cloud->fields[0].first.has_value());
}

/// Every recording and cloud of the data pack gives information or an error sentence.
TEST(Info, every_real_file_gives_information_or_an_error_message) {
  const fs::path data(RALI_DATA_DIR);
  if (!fs::exists(data / "recordings")) GTEST_SKIP() << "NOT CHECKED: no data pack at " << data;
  std::vector<std::string> files;
  for (const char* folder : {"recordings", "clouds"}) {
    for (const auto& entry : fs::recursive_directory_iterator(data / folder)) {
      files.push_back(entry.path().string());
    }
  }
  std::sort(files.begin(), files.end());
  std::size_t answered = 0;
  for (const std::string& file : files) {
    const auto info = look_into(file);
    const std::string extension = fs::path(file).extension().string();
    if (info) {
      ++answered;
      EXPECT_FALSE(info->topics.empty() && !info->cloud) << file;
    } else {
      EXPECT_FALSE(info.error().what.empty()) << file;
    }
    const bool ours = extension == ".bag" || extension == ".mcap" || extension == ".db3" ||
                      extension == ".pcd" || extension == ".ply";
    EXPECT_TRUE(!ours || info.has_value()) << file << (info ? "" : info.error().message());
  }
  EXPECT_GE(answered, 25U);
}

}  // namespace
}  // namespace rali::inspect
