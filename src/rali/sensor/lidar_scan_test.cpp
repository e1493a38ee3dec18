#include "rali/sensor/lidar_scan.hpp"

#include <gtest/gtest.h>

namespace rali::sensor {
namespace {

TEST(LidarScan, keeps_all_arrays_at_one_length) {
  LidarScan scan;
  scan.reserve(10);
  EXPECT_EQ(scan.size(), 0U);
  scan.push_back(1.0F, 2.0F, 3.0F, 40.0F, 0.05F, 7);
  scan.push_back(-1.0F, -2.0F, -3.0F, 0.0F, 0.06F, 15);
  ASSERT_EQ(scan.size(), 2U);
  EXPECT_EQ(scan.y_m.size(), 2U);
  EXPECT_EQ(scan.z_m.size(), 2U);
  EXPECT_EQ(scan.intensity.size(), 2U);
  EXPECT_EQ(scan.dt_s.size(), 2U);
  EXPECT_EQ(scan.ring.size(), 2U);
  EXPECT_EQ(scan.x_m[1], -1.0F);
  EXPECT_EQ(scan.y_m[1], -2.0F);
  EXPECT_EQ(scan.z_m[1], -3.0F);
  EXPECT_EQ(scan.intensity[0], 40.0F);
  EXPECT_EQ(scan.dt_s[0], 0.05F);
  EXPECT_EQ(scan.ring[1], 15);
}

TEST(LidarScan, clear_resets_all_fields_and_keeps_the_allocated_memory) {
  LidarScan scan;
  for (int k = 0; k < 100; ++k) scan.push_back(1.0F, 2.0F, 3.0F, 4.0F, 0.1F, 3);
  scan.t_start = Time::from_s(5.0);
  scan.t_end = Time::from_s(5.1);
  scan.has_point_times = scan.has_rings = scan.deskewed = true;
  scan.rings = 16;
  scan.dropped_nan = scan.dropped_range = scan.dropped_time = scan.dropped_return = 9;
  const std::size_t capacity = scan.x_m.capacity();
  scan.clear();
  EXPECT_EQ(scan.size(), 0U);
  EXPECT_TRUE(scan.ring.empty());
  EXPECT_TRUE(scan.dt_s.empty());
  EXPECT_TRUE(scan.intensity.empty());
  EXPECT_EQ(scan.t_start, Time{});
  EXPECT_EQ(scan.t_end, Time{});
  EXPECT_FALSE(scan.has_point_times || scan.has_rings || scan.deskewed);
  EXPECT_EQ(scan.rings, 0);
  EXPECT_EQ(scan.dropped_nan + scan.dropped_range + scan.dropped_time + scan.dropped_return, 0U);
  EXPECT_EQ(scan.x_m.capacity(), capacity);
}

}  // namespace
}  // namespace rali::sensor
