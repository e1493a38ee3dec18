#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "rali/sensor/lidar_models.hpp"
#include "rali/wire/decode.hpp"
#include "rali/wire/internal/cloud_layout.hpp"

// Real bytes of the data pack, as written by drivers and converters.
namespace rali::wire {
namespace {

using sensor::LidarScan;

std::filesystem::path data_dir() { return RALI_DATA_DIR; }

std::vector<std::byte> read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

#define SKIP_WITHOUT(path)                                             \
  do {                                                                 \
    if (!std::filesystem::exists(path)) {                              \
      GTEST_SKIP() << "DATA MISSING, NOT TESTED: " << (path).string(); \
    }                                                                  \
  } while (false)

/// Messages of an MCAP without chunks: records are opcode, 64-bit length, content.
std::vector<std::span<const std::byte>> mcap_messages(std::span<const std::byte> file) {
  std::vector<std::span<const std::byte>> found;
  std::size_t at = 8;
  while (at + 9 <= file.size()) {
    const auto opcode = std::to_integer<int>(file[at]);
    const auto length = load<std::uint64_t>(file.data() + at + 1, false);
    at += 9;
    if (length > file.size() - at) break;
    constexpr int kMessage = 5;
    constexpr std::size_t kMessageHeader = 2 + 4 + 8 + 8;
    const std::span<const std::byte> content = file.subspan(at, length);
    if (opcode == kMessage) found.push_back(content.subspan(kMessageHeader));
    at += length;
  }
  return found;
}

TEST(RealData, converted_kitti_mcap_matches_its_readme) {
  const auto path = data_dir() / "recordings/converted_pointcloud2/kitti16_3scans_nochunk.mcap";
  SKIP_WITHOUT(path);
  const std::vector<std::byte> file = read_file(path);
  std::vector<CloudView> clouds;
  for (const auto message : mcap_messages(file)) {
    const auto cloud = decode_point_cloud2(message, Encoding::kCdr);
    ASSERT_TRUE(cloud.has_value()) << cloud.error().message();
    clouds.push_back(*cloud);
  }
  ASSERT_EQ(clouds.size(), 3U);
  EXPECT_EQ(clouds[0].frame_id, "velodyne");
  EXPECT_EQ(clouds[0].point_step, 22U);
  EXPECT_NEAR(clouds[2].stamp.s(), 1000.0 + 2 * 0.10356, 1e-6);
  const auto format = decide_cloud_format(clouds, {});
  ASSERT_TRUE(format.has_value());
  EXPECT_EQ(format->point_time, PointTime::kRelativeS);
  EXPECT_NEAR(format->span_s, 0.1035, 0.001);
  EXPECT_NEAR(format->scan_period_s, 0.10356, 1e-5);
  EXPECT_EQ(format->rings, 16);
  LidarScan scan;
  ASSERT_TRUE(decode_cloud(clouds[0], *format, {}, scan).has_value());
  EXPECT_EQ(scan.size(), clouds[0].width);  // 1.46..80 m: all within the limits
  // the stamp is the middle of the scan
  EXPECT_NEAR(seconds_between(clouds[0].stamp, scan.t_start), -0.0518, 0.001);
  EXPECT_NEAR(seconds_between(clouds[0].stamp, scan.t_end), 0.0518, 0.001);
}

struct Pcd {
  std::vector<std::byte> bytes;
  CloudView cloud;
};

/// A minimal reader of a binary PCD: the points after the line DATA binary.
Pcd vlp16_pcd() {
  Pcd pcd;
  pcd.bytes = read_file(data_dir() / "clouds/vlp16_binary.pcd");
  const std::string_view text(reinterpret_cast<const char*>(pcd.bytes.data()), pcd.bytes.size());
  constexpr std::string_view kData = "DATA binary\n";
  pcd.cloud.height = 1;
  pcd.cloud.width = 14'831;
  pcd.cloud.point_step = 32;
  pcd.cloud.data = std::span(pcd.bytes).subspan(text.find(kData) + kData.size());
  pcd.cloud.fields = {
      {"x", 0, FieldType::kFloat32, 1},          {"y", 4, FieldType::kFloat32, 1},
      {"z", 8, FieldType::kFloat32, 1},          {"intensity", 12, FieldType::kUint8, 1},
      {"return_type", 13, FieldType::kUint8, 1}, {"channel", 14, FieldType::kUint16, 1},
      {"azimuth", 16, FieldType::kFloat32, 1},   {"elevation", 20, FieldType::kFloat32, 1},
      {"distance", 24, FieldType::kFloat32, 1},  {"time_stamp", 28, FieldType::kUint32, 1}};
  return pcd;
}

TEST(RealData, vlp16_times_that_restart_in_each_packet_are_replaced_by_azimuth) {
  const auto path = data_dir() / "clouds/vlp16_binary.pcd";
  SKIP_WITHOUT(path);
  const Pcd pcd = vlp16_pcd();
  const auto format = decide_cloud_format(std::span(&pcd.cloud, 1), {});
  ASSERT_TRUE(format.has_value());
  // 'time_stamp' runs from 0 to 1.3 ms in ns: the time within a packet, useless for the scan.
  EXPECT_EQ(format->point_time, PointTime::kAzimuth) << format->summary;
  EXPECT_NE(format->findings[0].text.find("'time_stamp' spans"), std::string::npos);
  EXPECT_EQ(format->rings, 16);
  EXPECT_EQ(format->model, "vlp16");
  LidarScan scan;
  ASSERT_TRUE(decode_cloud(pcd.cloud, *format, {}, scan).has_value());
  EXPECT_GT(scan.size(), 14'000U);
  EXPECT_EQ(scan.intensity[0], 100.0F);
  EXPECT_EQ(scan.ring[0], 8);
  // The points are in the order of measurement: so must their times be.
  std::size_t back = 0;
  for (std::size_t i = 100; i < scan.size(); ++i) {
    back += scan.dt_s[i] < scan.dt_s[i - 100] ? 1U : 0U;
  }
  EXPECT_LT(back, scan.size() / 100);
}

TEST(RealData, rings_of_a_vlp16_with_an_empty_ring_are_rebuilt_from_elevation) {
  const auto path = data_dir() / "clouds/vlp16_binary.pcd";
  SKIP_WITHOUT(path);
  Pcd pcd = vlp16_pcd();
  const auto with = decide_cloud_format(std::span(&pcd.cloud, 1), {});
  LidarScan want;
  ASSERT_TRUE(decode_cloud(pcd.cloud, *with, {}, want).has_value());
  for (CloudField& field : pcd.cloud.fields) {
    if (field.name == "channel") field.name = "hidden";
  }
  const auto without = decide_cloud_format(std::span(&pcd.cloud, 1), {});
  ASSERT_TRUE(without.has_value());
  EXPECT_EQ(without->ring_from, RingFrom::kElevation) << without->summary;
  EXPECT_EQ(without->rings, 16);
  EXPECT_EQ(without->model, "vlp16");
  LidarScan got;
  ASSERT_TRUE(decode_cloud(pcd.cloud, *without, {}, got).has_value());
  ASSERT_EQ(got.size(), want.size());
  std::size_t other_ring = 0;
  for (std::size_t i = 0; i < got.size(); ++i) {
    other_ring += got.ring[i] != want.ring[i] ? 1U : 0U;
  }
  EXPECT_LT(other_ring, got.size() / 100);
}

/// The list "beam_altitude_angles" of an Ouster's metadata, ascending [deg].
std::vector<float> beams_of(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path);
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::size_t at = text.find('[', text.find("beam_altitude_angles"));
  std::vector<float> beams_deg;
  while (at < text.size() && text[at] != ']') {
    std::size_t used = 0;
    beams_deg.push_back(std::stof(text.substr(at + 1, 32), &used));
    at = text.find_first_of(",]", at + 1 + used);
  }
  std::sort(beams_deg.begin(), beams_deg.end());
  return beams_deg;
}

TEST(RealData, ouster_models_are_identified_from_beam_angles_of_real_units) {
  const auto dir = data_dir() / "recordings/ouster";
  SKIP_WITHOUT(dir);
  const std::pair<const char*, const char*> units[] = {
      {"OS-0-128-U1_v2.3.0_1024x10.json", "os0_128"},
      {"OS-1-128_v2.3.0_1024x10.json", "os1_128"},
      {"OS-1-64_sensor_config_reduced.json", "os1_64"},
      {"OS-2-32-U0_v2.0.0_1024x10.json", "os2_32"}};
  for (const auto& unit : units) {
    std::vector<float> beams_rad = beams_of(dir / unit.first);
    ASSERT_GE(beams_rad.size(), 32U) << unit.first;
    for (float& beam : beams_rad) beam *= 3.14159265F / 180.0F;
    const sensor::LidarModel* found = sensor::identify_lidar(beams_rad);
    ASSERT_NE(found, nullptr) << unit.second;
    EXPECT_EQ(found->name, unit.second);
  }
}

TEST(RealData, kitti_bin_clouds_get_times_from_azimuth_and_rings_from_elevation) {
  const auto dir = data_dir() / "kitti_0005/scans64_full";
  SKIP_WITHOUT(dir);
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(dir)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  ASSERT_FALSE(files.empty());
  const std::vector<std::byte> bytes = read_file(files[0]);
  CloudView cloud;
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(bytes.size() / 16);
  cloud.point_step = 16;
  cloud.data = bytes;
  cloud.fields = {{"x", 0, FieldType::kFloat32, 1},
                  {"y", 4, FieldType::kFloat32, 1},
                  {"z", 8, FieldType::kFloat32, 1},
                  {"intensity", 12, FieldType::kFloat32, 1}};
  CloudFormatOptions options;
  options.model = "hdl64e";
  options.scan_period_s = 0.10356;
  const auto format = decide_cloud_format(std::span(&cloud, 1), options);
  ASSERT_TRUE(format.has_value());
  EXPECT_EQ(format->point_time, PointTime::kAzimuth) << format->summary;
  EXPECT_TRUE(format->azimuth_clockwise);
  LidarScan scan;
  ASSERT_TRUE(decode_cloud(cloud, *format, options, scan).has_value());
  EXPECT_EQ(scan.rings, 64);
  for (std::size_t i = 0; i < scan.size(); i += 1013) {
    const double azimuth = std::atan2(scan.y_m[i], scan.x_m[i]);
    const double fraction = 0.5 * (1.0 - azimuth / 3.14159265358979);
    EXPECT_NEAR(static_cast<double>(scan.dt_s[i]), fraction * 0.10356, 2e-4);
  }
}

}  // namespace
}  // namespace rali::wire
