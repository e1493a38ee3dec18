#include "rali/report/thinned_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "rali/io/files/cloud_writers.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::report {
namespace {

/// Point i is at (i, -i, i/2), of vehicle i % 3.
void write_points(const io::TestFolder& folder, std::size_t n, bool ply) {
  std::vector<float> x(n), y(n), z(n), intensity(n, 1.0F), sigma(n);
  std::vector<std::uint16_t> seen(n, 1);
  std::vector<std::uint8_t> vehicle(n);
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = static_cast<float>(i);
    y[i] = -x[i];
    z[i] = 0.5F * x[i];
    sigma[i] = 0.25F;
    vehicle[i] = static_cast<std::uint8_t>(i % 3);
  }
  const io::MapColumns columns{x, y, z, intensity, sigma, seen, vehicle};
  if (ply) {
    ASSERT_TRUE(io::write_map_ply(folder.path("map.ply"), n, io::one_part(columns)));
  } else {
    ASSERT_TRUE(io::write_map_pcd(folder.path("map.pcd"), n, io::one_part(columns)));
  }
}

TEST(ThinnedMap, of_a_small_file_has_every_point_in_order) {
  for (const bool ply : {false, true}) {
    const io::TestFolder folder;
    constexpr std::size_t kPoints = 100'003;  // more than one chunk, and no multiple of it
    write_points(folder, kPoints, ply);
    const auto map = read_thinned_map(folder.path(ply ? "map.ply" : "map.pcd"));
    ASSERT_TRUE(map) << map.error().message();
    ASSERT_EQ(map->points.size(), kPoints);
    EXPECT_EQ(map->points_in_file, kPoints);
    EXPECT_TRUE(map->note.empty());
    for (std::size_t i = 0; i < kPoints; i += 997) {
      ASSERT_EQ(map->points.x_m[i], static_cast<float>(i));
      ASSERT_EQ(map->points.y_m[i], -static_cast<float>(i));
      ASSERT_EQ(map->points.z_m[i], 0.5F * static_cast<float>(i));
      ASSERT_EQ(map->points.sigma_m[i], 0.25F);
      ASSERT_EQ(map->points.vehicle[i], i % 3);
    }
  }
}

TEST(ThinnedMap, samples_the_requested_number_evenly_and_deterministically) {
  const io::TestFolder folder;
  write_points(folder, 200'000, false);
  const auto a = read_thinned_map(folder.path("map.pcd"), 20'000);
  const auto b = read_thinned_map(folder.path("map.pcd"), 20'000);
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(static_cast<double>(a->points.size()), 20'000.0, 600.0);
  EXPECT_EQ(a->points_in_file, 200'000U);
  EXPECT_EQ(a->points.x_m, b->points.x_m);
  EXPECT_LT(a->points.x_m.front(), 200.0F);
  EXPECT_GT(a->points.x_m.back(), 199'800.0F);
  const auto ones = std::count(a->points.vehicle.begin(), a->points.vehicle.end(), 1);
  EXPECT_NEAR(static_cast<double>(ones), 20'000.0 / 3.0, 400.0) << "no vehicle is preferred";
}

TEST(ThinnedMap, of_a_truncated_file_has_the_remaining_points_and_a_note) {
  const io::TestFolder folder;
  write_points(folder, 1000, false);
  const std::string whole = folder.read("map.pcd");
  folder.write("map.pcd", whole.substr(0, whole.size() - 23 * 400 - 5));
  const auto map = read_thinned_map(folder.path("map.pcd"));
  ASSERT_TRUE(map);
  EXPECT_EQ(map->points.size(), 599U);
  EXPECT_EQ(map->note, "is cut: 599 of 1000 points are there");
}

TEST(ThinnedMap, allocates_no_memory_for_points_missing_after_the_header) {
  const io::TestFolder folder;
  folder.write("map.pcd",
               "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 300000000\n"
               "HEIGHT 1\nPOINTS 300000000\nDATA binary\nabcdabcdabcd");
  const auto map = read_thinned_map(folder.path("map.pcd"));
  ASSERT_TRUE(map) << map.error().message();
  EXPECT_EQ(map->points_in_file, 1U);
  folder.write("map.ply",
               "ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\n"
               "property float x\nproperty float y\nproperty float z\nend_header\n");
  const auto ply = read_thinned_map(folder.path("map.ply"));
  EXPECT_TRUE(!ply || ply->points.size() == 0U);
}

TEST(ThinnedMap, reads_ascii_and_refuses_files_that_are_no_cloud) {
  const io::TestFolder folder;
  folder.write("map.pcd",
               "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n"
               "POINTS 2\nDATA ascii\n1 2 3\n4 5 6\n");
  const auto map = read_thinned_map(folder.path("map.pcd"));
  ASSERT_TRUE(map) << map.error().message();
  ASSERT_EQ(map->points.size(), 2U);
  EXPECT_EQ(map->points.z_m[1], 6.0F);
  EXPECT_TRUE(std::isnan(map->points.sigma_m[0])) << "not known is not zero";
  for (const std::string& text :
       {std::string(), std::string("no cloud"), std::string(5000, '\0')}) {
    folder.write("map.pcd", text);
    EXPECT_FALSE(read_thinned_map(folder.path("map.pcd")));
  }
  EXPECT_FALSE(read_thinned_map(folder.path("absent.pcd")));
  EXPECT_FALSE(read_thinned_map(folder.path()));
}

}  // namespace
}  // namespace rali::report
