#include "rali/odometry/robust/scan_sampler.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "rali/odometry/room_for_test.hpp"

namespace rali::odometry {
namespace {

TEST(ScanSampler, keeps_point_counts_near_targets_in_small_and_large_rooms) {
  for (const double scale : {0.3, 1.0, 10.0}) {
    TestRoom room;
    room.walls.lo *= scale;
    room.walls.hi *= scale;
    room.pillars.clear();
    room.columns = 900;
    ScanSampler sampler{SamplingSettings{}};
    const auto scan = room.scan(0.0);
    for (int k = 0; k < 4; ++k) sampler.sample(*scan);
    EXPECT_GT(sampler.update_indices().size(), 700U) << scale;
    EXPECT_LT(sampler.update_indices().size(), 3100U) << scale;
    EXPECT_GT(sampler.insert_indices().size(), 2900U) << scale;
    EXPECT_LE(sampler.insert_indices().size(), 12200U) << scale;
    // The points of the update are a subset of those for the map.
    EXPECT_TRUE(std::includes(sampler.insert_indices().begin(), sampler.insert_indices().end(),
                              sampler.update_indices().begin(), sampler.update_indices().end()));
  }
}

TEST(ScanSampler, accepts_scans_with_zero_or_one_point) {
  ScanSampler sampler{SamplingSettings{}};
  sensor::LidarScan scan;
  sampler.sample(scan);
  EXPECT_TRUE(sampler.update_indices().empty());
  scan.push_back(1.0F, 2.0F, 3.0F, 0.0F, 0.0F, 0);
  sampler.sample(scan);
  EXPECT_EQ(sampler.update_indices(), (std::vector<std::uint32_t>{0}));
  EXPECT_EQ(sampler.insert_indices(), (std::vector<std::uint32_t>{0}));
}

TEST(ThinEvenly, keeps_the_requested_count_without_favouring_a_ring) {
  std::vector<std::uint32_t> indices(16000);
  for (std::uint32_t i = 0; i < indices.size(); ++i) indices[i] = i;
  thin_evenly(indices, 4000);
  EXPECT_NEAR(static_cast<double>(indices.size()), 4000.0, 250.0);
  std::array<int, 16> per_ring{};
  for (const std::uint32_t i : indices) ++per_ring[i % 16];
  for (const int n : per_ring) EXPECT_NEAR(n, 250, 70);
  const std::vector<std::uint32_t> before = indices;
  thin_evenly(indices, 16000);
  EXPECT_EQ(indices, before);
}

}  // namespace
}  // namespace rali::odometry
