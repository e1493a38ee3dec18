#include "rali/io/files/cloud_writers.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

struct Map {
  std::vector<float> x, y, z, intensity, sigma;
  std::vector<std::uint16_t> seen;
  std::vector<std::uint8_t> vehicle;

  explicit Map(std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
      const float f = static_cast<float>(i);
      x.push_back(0.25F + f);
      y.push_back(-f);
      z.push_back(0.001F * f);
      intensity.push_back(f * 100.0F);
      sigma.push_back(0.01F * f);
      seen.push_back(static_cast<std::uint16_t>(i * 7));
      vehicle.push_back(static_cast<std::uint8_t>(i % 3));
    }
  }

  [[nodiscard]] MapColumns part(std::size_t begin, std::size_t n) const {
    return {std::span(x).subspan(begin, n),      std::span(y).subspan(begin, n),
            std::span(z).subspan(begin, n),      std::span(intensity).subspan(begin, n),
            std::span(sigma).subspan(begin, n),  std::span(seen).subspan(begin, n),
            std::span(vehicle).subspan(begin, n)};
  }

  [[nodiscard]] MapColumns all() const { return part(0, x.size()); }
};

template <class T>
std::vector<double> doubles(const std::vector<T>& values) {
  return {values.begin(), values.end()};
}

void expect_same(const CloudFile& cloud, const Map& map) {
  EXPECT_EQ(cloud.point_step, 23U);
  EXPECT_EQ(cloud.column(cloud.field("x")), doubles(map.x));
  EXPECT_EQ(cloud.column(cloud.field("y")), doubles(map.y));
  EXPECT_EQ(cloud.column(cloud.field("z")), doubles(map.z));
  EXPECT_EQ(cloud.column(cloud.field("intensity")), doubles(map.intensity));
  EXPECT_EQ(cloud.column(cloud.field("sigma")), doubles(map.sigma));
  EXPECT_EQ(cloud.column(cloud.field("seen")), doubles(map.seen));
  EXPECT_EQ(cloud.column(cloud.field("vehicle")), doubles(map.vehicle));
}

TEST(CloudWriters, map_pcd_and_ply_are_read_back_bit_by_bit) {
  const TestFolder folder;
  const Map map(5000);  // more than one lot
  ASSERT_TRUE(write_map_pcd(folder.path("map.pcd"), 5000, one_part(map.all())));
  ASSERT_TRUE(write_map_ply(folder.path("map.ply"), 5000, one_part(map.all())));
  const auto pcd = read_cloud_file(folder.path("map.pcd"));
  const auto ply = read_cloud_file(folder.path("map.ply"));
  ASSERT_TRUE(pcd && ply);
  expect_same(*pcd, map);
  expect_same(*ply, map);
}

TEST(CloudWriters, writing_in_parts_gives_the_same_bytes_as_at_once) {
  const TestFolder folder;
  const Map map(100);
  std::size_t at = 0;
  const auto parts = [&](MapColumns& out) -> Result<bool> {
    if (at >= 100) return false;
    out = map.part(at, 20);
    at += 20;
    return true;
  };
  for (const auto write : {write_map_pcd, write_map_ply}) {
    at = 0;
    ASSERT_TRUE(write(folder.path("a"), 100, parts));
    ASSERT_TRUE(write(folder.path("b"), 100, one_part(map.all())));
    EXPECT_EQ(folder.read("a"), folder.read("b"));
  }
}

TEST(CloudWriters, an_error_of_the_point_source_leaves_no_file) {
  const TestFolder folder;
  const auto parts = [](MapColumns&) -> Result<bool> {
    return fail(ErrorCode::kMachine, "tile", "is gone");
  };
  EXPECT_FALSE(write_map_pcd(folder.path("a"), 1, parts));
  EXPECT_FALSE(write_map_las(folder.path("a"), 1, parts));
  EXPECT_EQ(folder.files(), 0U);
}

TEST(CloudWriters, an_empty_map_is_a_valid_file) {
  const TestFolder folder;
  ASSERT_TRUE(write_map_pcd(folder.path("map.pcd"), 0, one_part({})));
  ASSERT_TRUE(write_map_ply(folder.path("map.ply"), 0, one_part({})));
  ASSERT_TRUE(write_map_las(folder.path("map.las"), 0, one_part({})));
  EXPECT_EQ(read_cloud_file(folder.path("map.pcd"))->size(), 0U);
  EXPECT_EQ(read_cloud_file(folder.path("map.ply"))->size(), 0U);
}

TEST(CloudWriters, keyframe_pcd_is_read_back_with_and_without_rings) {
  const TestFolder folder;
  const Map map(10);
  KeyframeColumns columns{map.x, map.y, map.z, map.intensity, map.seen};
  ASSERT_TRUE(write_keyframe_pcd(folder.path("0.pcd"), columns));
  const auto with = read_cloud_file(folder.path("0.pcd"));
  ASSERT_TRUE(with);
  EXPECT_EQ(with->point_step, 18U);
  EXPECT_EQ(with->column(with->field("ring")), doubles(map.seen));
  EXPECT_EQ(with->column(with->field("z")), doubles(map.z));
  columns.ring = {};
  ASSERT_TRUE(write_keyframe_pcd(folder.path("1.pcd"), columns));
  const auto without = read_cloud_file(folder.path("1.pcd"));
  EXPECT_EQ(without->column(without->field("ring")), std::vector<double>(10, 0.0));
}

template <class T>
T at(const std::string& bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// Offsets taken from the LAS 1.4 specification, not from the writer.
TEST(LasWriter, header_and_points_match_the_las_1_4_layout) {
  const TestFolder folder;
  const Map map(60);
  LasOptions options;
  options.shift_m = {500000.0, 5000000.0, 100.0};
  ASSERT_TRUE(write_map_las(folder.path("map.las"), 60, one_part(map.all()), options));
  const std::string las = folder.read("map.las");
  EXPECT_EQ(las.substr(0, 4), "LASF");
  EXPECT_EQ(at<std::uint16_t>(las, 6), 16);  // WKT bit
  EXPECT_EQ(at<std::uint8_t>(las, 24), 1);   // version 1.4
  EXPECT_EQ(at<std::uint8_t>(las, 25), 4);
  EXPECT_EQ(at<std::uint32_t>(las, 90), 0U);  // no date
  EXPECT_EQ(at<std::uint16_t>(las, 94), 375);
  const auto points_at = at<std::uint32_t>(las, 96);
  EXPECT_EQ(points_at, 375U + 54U + 192U);
  EXPECT_EQ(at<std::uint32_t>(las, 100), 1U);
  EXPECT_EQ(at<std::uint8_t>(las, 104), 6);
  EXPECT_EQ(at<std::uint16_t>(las, 105), 34);
  EXPECT_EQ(at<double>(las, 131), 0.001);
  EXPECT_EQ(at<double>(las, 155), 500000.0);
  EXPECT_EQ(at<double>(las, 163), 5000000.0);
  EXPECT_NEAR(at<double>(las, 179), 500059.25, 1e-6);  // max x
  EXPECT_NEAR(at<double>(las, 187), 500000.25, 1e-6);  // min x
  EXPECT_NEAR(at<double>(las, 195), 5000000.0, 1e-6);  // max y
  EXPECT_NEAR(at<double>(las, 203), 4999941.0, 1e-6);  // min y
  EXPECT_EQ(at<std::uint64_t>(las, 247), 60U);
  EXPECT_EQ(at<std::uint64_t>(las, 255), 60U);
  EXPECT_EQ(las.substr(375 + 2, 9), "LASF_Spec");
  EXPECT_EQ(at<std::uint16_t>(las, 375 + 18), 4);
  EXPECT_EQ(at<std::uint16_t>(las, 375 + 20), 192);
  EXPECT_EQ(at<std::uint8_t>(las, 375 + 54 + 2), 9);
  EXPECT_EQ(las.substr(375 + 54 + 4, 6), std::string("sigma\0", 6));
  EXPECT_EQ(las.substr(375 + 54 + 160, 8), "position");
  ASSERT_EQ(las.size(), points_at + 60U * 34U);
  const std::size_t p = points_at + 50U * 34U;
  EXPECT_EQ(at<std::int32_t>(las, p), 50250);
  EXPECT_EQ(at<std::int32_t>(las, p + 4), -50000);
  EXPECT_EQ(at<std::int32_t>(las, p + 8), 50);
  EXPECT_EQ(at<std::uint16_t>(las, p + 12), 5000);
  EXPECT_EQ(at<std::uint8_t>(las, p + 14), 0x11);
  EXPECT_EQ(at<std::uint8_t>(las, p + 17), 255);     // seen 350
  EXPECT_EQ(at<std::uint16_t>(las, p + 20), 2 + 1);  // vehicle 50 % 3
  EXPECT_FLOAT_EQ(at<float>(las, p + 30), 0.5F);
}

TEST(LasWriter, refuses_what_las_cannot_hold_and_leaves_no_file) {
  const TestFolder folder;
  Map map(3);
  map.x[2] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(write_map_las(folder.path("a"), 3, one_part(map.all())).error().code,
            ErrorCode::kInput);
  map.x[2] = 3e6F;
  EXPECT_FALSE(write_map_las(folder.path("a"), 3, one_part(map.all())));
  EXPECT_EQ(folder.files(), 0U);
}

TEST(LasWriter, intensities_are_scaled_and_clamped_to_16_bits) {
  const TestFolder folder;
  Map map(3);
  map.intensity = {0.5F, 2.0F, -1.0F};
  LasOptions options;
  options.intensity_scale = 65535.0;
  ASSERT_TRUE(write_map_las(folder.path("a"), 3, one_part(map.all()), options));
  const std::string las = folder.read("a");
  EXPECT_EQ(at<std::uint16_t>(las, 621 + 12), 32768);
  EXPECT_EQ(at<std::uint16_t>(las, 621 + 34 + 12), 65535);
  EXPECT_EQ(at<std::uint16_t>(las, 621 + 68 + 12), 0);
}

}  // namespace
}  // namespace rali::io
