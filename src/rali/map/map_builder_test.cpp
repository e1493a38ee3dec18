#include "rali/map/map_builder.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/map/point_error.hpp"
#include "rali/map/test_world.hpp"

namespace rali::map {
namespace {

MapSettings without_noise() {
  MapSettings s;
  s.range_sigma_m = s.bearing_sigma_rad = s.systematic_m = 0.0;
  return s;
}

MapCloud finished(const MapBuilder& builder) {
  FindingList findings;
  return builder.finish({}, findings).map;
}

TEST(VoxelKey, negative_coordinates_round_down_not_to_zero) {
  EXPECT_NE(voxel_key(geometry::Vec3{-0.01, 0, 0}, 0.05),
            voxel_key(geometry::Vec3{0.01, 0, 0}, 0.05));
  const VoxelKey key = voxel_key(geometry::Vec3{-0.01, 0.12, -3.0}, 0.05);
  EXPECT_TRUE(voxel_corner(key, 0.05).isApprox(geometry::Vec3{-0.05, 0.10, -3.0}, 1e-12));
}

TEST(VoxelKey, non_finite_or_far_coordinates_have_no_voxel) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(voxel_key(geometry::Vec3{0, kNan, 0}, 0.05), kNoVoxel);
  EXPECT_EQ(voxel_key(geometry::Vec3{kInf, 0, 0}, 0.05), kNoVoxel);
  EXPECT_EQ(voxel_key(geometry::Vec3{0, 0, 1e9}, 0.05), kNoVoxel);
}

TEST(VoxelIndex, numbers_keys_in_order_of_insertion_and_finds_them_after_growing) {
  VoxelIndex index;
  for (int i = 0; i < 5000; ++i) {
    const auto slot = index.insert(voxel_key(i, -i, i % 7));
    EXPECT_TRUE(slot.is_new);
    ASSERT_EQ(slot.index, static_cast<std::uint32_t>(i));
  }
  EXPECT_FALSE(index.insert(voxel_key(17, -17, 3)).is_new);
  EXPECT_EQ(index.find(voxel_key(4999, -4999, 4999 % 7)), 4999U);
  EXPECT_FALSE(index.find(voxel_key(-1, 0, 0)).has_value());
  EXPECT_FALSE(index.find(kNoVoxel).has_value());
}

TEST(PointError, equals_the_trace_of_the_propagated_covariance) {
  Rng rng(3, "point_error");
  geometry::Mat6 A;
  for (int i = 0; i < 36; ++i) A(i) = 0.1 * rng.normal();
  const geometry::Mat6 P = A * A.transpose();
  const geometry::Mat3 R = geometry::so3_exp({0.3, -1.2, 2.0});
  const PointError error(P, R);
  const geometry::Vec3 p{3.0, -7.0, 1.5};
  Eigen::Matrix<double, 3, 6> J;
  J << -R * geometry::skew(p), geometry::Mat3::Identity();
  EXPECT_NEAR(error.variance_m2(p), (J * P * J.transpose()).trace(), 1e-12);
}

TEST(PointError, one_degree_of_yaw_moves_a_point_at_ten_metres_by_17_cm) {
  geometry::Mat6 P = geometry::Mat6::Zero();
  P(2, 2) = std::pow(0.0174533, 2);
  EXPECT_NEAR(std::sqrt(PointError(P, geometry::Mat3::Identity()).variance_m2({10, 0, 5})),
              0.174533, 1e-6);
}

TEST(MapBuilder, two_points_of_one_voxel_become_their_mean) {
  MapBuilder builder(without_noise());
  test::Scan scan;
  scan.add(1.01, 2.01, 3.01, 0, 10.0F);
  scan.add(1.03, 2.03, 3.03, 0, 30.0F);
  builder.add(scan.view());
  const MapCloud map = finished(builder);
  ASSERT_EQ(map.size(), 1U);
  EXPECT_NEAR(map.x_m[0], 1.02F, 1e-5F);
  EXPECT_NEAR(map.z_m[0], 3.02F, 1e-5F);
  EXPECT_FLOAT_EQ(map.intensity[0], 20.0F);
  EXPECT_EQ(map.seen[0], 1);
}

TEST(MapBuilder, voxel_zero_keeps_every_point_in_order) {
  MapSettings s = without_noise();
  s.voxel_m = 0.0;
  MapBuilder builder(s);
  test::Scan scan;
  scan.add(5.0, 0, 0);
  scan.add(1.0, 0, 0);
  scan.add(1.0, 0, 0);
  builder.add(scan.view());
  const MapCloud map = finished(builder);
  ASSERT_EQ(map.size(), 3U);
  EXPECT_FLOAT_EQ(map.x_m[0], 5.0F);
  EXPECT_FLOAT_EQ(map.x_m[2], 1.0F);
}

TEST(MapBuilder, seen_counts_keyframes_not_points) {
  MapBuilder builder(without_noise());
  test::Scan scan;
  for (int i = 0; i < 5; ++i) scan.add(1.01, 2.01, 3.01);
  for (int k = 0; k < 3; ++k) builder.add(scan.view());
  EXPECT_EQ(finished(builder).seen[0], 3);
}

TEST(MapBuilder, range_noise_averages_out_but_a_common_pose_error_does_not) {
  MapSettings s = without_noise();
  s.range_sigma_m = 0.02;
  test::Scan scan;
  scan.add(1.01, 2.01, 3.01);
  MapBuilder noise_only(s);
  for (int k = 0; k < 100; ++k) noise_only.add(scan.view());
  EXPECT_NEAR(finished(noise_only).sigma_m[0], 0.002F, 1e-6F);

  scan.covariance.bottomRightCorner<3, 3>() = geometry::Mat3::Identity() * 0.01;
  MapBuilder with_pose(s);
  for (int k = 0; k < 100; ++k) with_pose.add(scan.view());
  // sqrt(3 * 0.01 + 0.02^2 / 100)
  EXPECT_NEAR(finished(with_pose).sigma_m[0], std::sqrt(0.030004F), 1e-5F);
}

TEST(MapBuilder, drops_nan_points_and_reports_them) {
  MapBuilder builder(without_noise());
  test::Scan scan;
  scan.add(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  scan.add(1, 1, 1);
  builder.add(scan.view());
  FindingList findings;
  EXPECT_EQ(builder.finish({}, findings).map.size(), 1U);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "map.points");
}

TEST(MapBuilder, refuses_a_keyframe_with_a_nan_pose) {
  MapBuilder builder(without_noise());
  test::Scan scan;
  scan.add(1, 1, 1);
  scan.T_map_body.p.x() = std::numeric_limits<double>::quiet_NaN();
  builder.add(scan.view());
  FindingList findings;
  EXPECT_EQ(builder.finish({}, findings).map.size(), 0U);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "map.keyframe");
}

TEST(MapBuilder, stops_at_its_memory_limit_and_reports_an_error) {
  MapSettings s = without_noise();
  s.max_memory_mb = 1.0;
  MapBuilder builder(s);
  test::Scan scan;
  for (int i = 0; i < 60000; ++i) scan.add(0.1 * i, 0, 0);
  builder.add(scan.view());
  EXPECT_LE(static_cast<double>(builder.memory_bytes()), 1e6);
  EXPECT_LT(builder.size(), 60000U);
  FindingList findings;
  static_cast<void>(builder.finish({}, findings));
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "map.memory");
  EXPECT_EQ(findings[0].severity, Severity::kError);
}

TEST(MapBuilder, sorts_the_map_by_voxel) {
  MapBuilder builder(without_noise());
  test::Scan scan;
  Rng rng(1, "order");
  for (int i = 0; i < 1000; ++i) scan.add(rng.uniform(-9, 9), rng.uniform(-9, 9), 0);
  builder.add(scan.view());
  const MapCloud map = finished(builder);
  for (std::size_t i = 1; i < map.size(); ++i) {
    EXPECT_LE(std::floor(map.x_m[i - 1] / 0.05F), std::floor(map.x_m[i] / 0.05F) + 1.0F);
  }
}

TEST(MapBuilder, keeps_millimetre_resolution_far_from_the_origin) {
  MapBuilder builder(without_noise());
  test::Scan scan;
  scan.T_map_body.p = {40000.0, -12000.0, 0.0};
  scan.add(1.012, 0, 0);
  builder.add(scan.view());
  const MapCloud map = finished(builder);
  ASSERT_EQ(map.size(), 1U);
  EXPECT_EQ(map.origin_map_m.x(), 40000.0);
  EXPECT_NEAR(map.x_m[0], 1.012F, 1e-5F);
}

}  // namespace
}  // namespace rali::map
