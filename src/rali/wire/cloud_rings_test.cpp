#include <gtest/gtest.h>

#include "rali/wire/cloud_format.hpp"
#include "rali/wire/internal/test_clouds.hpp"

namespace rali::wire {
namespace {

using internal::expect_third;
using internal::has_finding;
using internal::kStart;
using internal::three;
using internal::views;
using internal::vlp16_scan;
using sensor::LidarScan;

TEST(CloudRings, invalid_ring_fields_are_replaced_by_elevation) {
  auto clouds = three(CloudStyle::kVelodyne);
  for (PackedCloud& cloud : clouds) {
    for (std::size_t i = 0; i < cloud.view.width; ++i) {
      std::fill_n(cloud.data.begin() + static_cast<std::ptrdiff_t>(i * 22 + 16), 2, std::byte{0});
    }
  }
  const auto format = decide_cloud_format(views(clouds), {});
  ASSERT_TRUE(format.has_value());
  EXPECT_EQ(format->ring_from, RingFrom::kElevation);
  EXPECT_EQ(format->rings, 16);
  EXPECT_TRUE(has_finding(*format, "D06"));
  expect_third(clouds[2].view, *format, {}, 1e-6);
}

TEST(CloudRings, rings_in_firing_order_are_accepted_with_a_finding) {
  constexpr std::uint16_t kFiring[] = {0, 8, 1, 9, 2, 10, 3, 11, 4, 12, 5, 13, 6, 14, 7, 15};
  std::vector<PackedCloud> clouds;
  for (int i = 0; i < 2; ++i) {
    LidarScan scan = vlp16_scan(kStart + Duration::from_s(0.1 * i));
    for (auto& ring : scan.ring) ring = kFiring[ring];
    clouds.push_back(pack_cloud(scan, "", CloudStyle::kVelodyne));
  }
  const auto format = decide_cloud_format(views(clouds), {});
  ASSERT_TRUE(format.has_value());
  EXPECT_EQ(format->rings, 16);
  EXPECT_EQ(format->model, "vlp16");
  EXPECT_TRUE(has_finding(*format, "D06"));
}

TEST(CloudRings, every_model_with_rings_is_found_from_its_elevations) {
  for (const sensor::LidarModel& model : sensor::lidar_models()) {
    if (model.elevations_deg.empty()) continue;
    const LidarScan scan = internal::room_scan(model.elevations_deg, 300, kStart);
    const PackedCloud cloud = pack_cloud(scan, "", CloudStyle::kXyzi);
    const auto format = decide_cloud_format(std::span(&cloud.view, 1), {});
    ASSERT_TRUE(format.has_value());
    EXPECT_EQ(format->rings, model.lines) << model.name << ": " << format->summary;
    const sensor::LidarModel* found = sensor::find_lidar_model(format->model);
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(found->lines, model.lines) << model.name << ": " << format->summary;
  }
}

}  // namespace
}  // namespace rali::wire
