#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "rali/sim/lidar_sensor.hpp"

namespace rali::sim {
namespace {

using geometry::SE3;
using geometry::Vec3;

/// A box of 20 x 20 x 6 m around the origin.
TriangleMesh hall() {
  TriangleMesh mesh;
  mesh.add_box({0.0, 0.0, -3.0}, {20.0, 20.0, 6.0}, 0.0, 0.6);
  return mesh;
}

std::shared_ptr<const sensor::LidarScan> scan_of(const TriangleMesh& mesh, Lidar kind,
                                                 const LidarOptions& options, const SE3& T) {
  const RayCaster caster(mesh);
  LidarSensor lidar(kind, options, 1);
  SerialExecutor serial;
  const RawScan& raw = lidar.measure_scan(
      0, 0.0, [&](double) { return T; }, caster, MovingScene(), serial);
  return expand(raw, lidar.model(), options.resolution_m, Time::from_ns(1));
}

TEST(LidarSensor, points_have_the_elevation_of_their_ring_and_lie_on_walls) {
  LidarOptions o;
  o.noise_m = 0.0;
  const auto scan = scan_of(hall(), Lidar::kRs16, o, SE3{});
  ASSERT_EQ(scan->size(), 28800U);
  const std::vector<double> angles = LidarModel(Lidar::kRs16).elevations_rad();
  for (std::size_t i = 0; i < scan->size(); i += 101) {
    const double x = static_cast<double>(scan->x_m[i]);
    const double y = static_cast<double>(scan->y_m[i]);
    const double z = static_cast<double>(scan->z_m[i]);
    EXPECT_NEAR(std::atan2(z, std::hypot(x, y)), angles[scan->ring[i]], 1e-6);
    const double wall = std::max({std::abs(x) - 10.0, std::abs(y) - 10.0, std::abs(z) - 3.0});
    EXPECT_NEAR(wall, 0.0, 0.0011);
  }
}

TEST(LidarSensor, range_noise_has_the_set_sigma_and_zero_mean) {
  LidarOptions o;
  o.mixed_fraction = 0.0;
  const auto noisy = scan_of(hall(), Lidar::kRs16, o, SE3{});
  o.noise_m = 0.0;
  const auto clean = scan_of(hall(), Lidar::kRs16, o, SE3{});
  ASSERT_EQ(noisy->size(), clean->size());
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < noisy->size(); ++i) {
    const double a = std::hypot(noisy->x_m[i], noisy->y_m[i], noisy->z_m[i]);
    const double b = std::hypot(clean->x_m[i], clean->y_m[i], clean->z_m[i]);
    sum += a - b;
    squares += (a - b) * (a - b);
  }
  const double n = static_cast<double>(noisy->size());
  EXPECT_NEAR(sum / n, 0.0, 4.0 * 0.02 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), 0.02, 4.0 * 0.02 / std::sqrt(2.0 * n));
}

// The error of a laser is constant: averaging over the sensor hides it, averaging over time does
// not.
TEST(LidarSensor, range_offsets_are_constant_per_laser) {
  LidarOptions o;
  o.noise_m = o.mixed_fraction = 0.0;
  const auto clean = scan_of(hall(), Lidar::kRs16, o, SE3{});
  o.laser_offset_m = 0.02;
  const auto wrong = scan_of(hall(), Lidar::kRs16, o, SE3{});
  ASSERT_EQ(wrong->size(), clean->size());
  const auto range_m = [](const sensor::LidarScan& s, std::size_t i) {
    return std::hypot(s.x_m[i], s.y_m[i], s.z_m[i]);
  };
  std::vector<double> offset_m(16, 0.0);
  for (std::size_t i = 0; i < clean->size(); ++i) {
    const double now_m = range_m(*wrong, i) - range_m(*clean, i);
    double& first_m = offset_m[clean->ring[i]];
    if (first_m == 0.0) first_m = now_m;
    ASSERT_NEAR(now_m, first_m, 2.1 * o.resolution_m) << i;
  }
  double squares = 0.0;
  for (const double x_m : offset_m) squares += x_m * x_m / 16.0;
  EXPECT_NEAR(std::sqrt(squares), o.laser_offset_m, 0.01);
}

TEST(LidarSensor, laser_elevation_errors_displace_points_by_more_than_0_02_m) {
  LidarOptions o;
  o.noise_m = o.mixed_fraction = 0.0;
  o.laser_elevation_deg = 0.5;
  const auto scan = scan_of(hall(), Lidar::kRs16, o, SE3{});
  const std::vector<double> angles = LidarModel(Lidar::kRs16).elevations_rad();
  double worst_m = 0.0;
  for (std::size_t i = 0; i < scan->size(); ++i) {
    const double x = static_cast<double>(scan->x_m[i]), y = static_cast<double>(scan->y_m[i]);
    const double z = static_cast<double>(scan->z_m[i]);
    EXPECT_NEAR(std::atan2(z, std::hypot(x, y)), angles[scan->ring[i]], 1e-6);
    const double wall = std::max({std::abs(x) - 10.0, std::abs(y) - 10.0, std::abs(z) - 3.0});
    worst_m = std::max(worst_m, std::abs(wall));
  }
  EXPECT_GT(worst_m, 0.02);
}

TEST(LidarSensor, dark_grazing_and_far_surfaces_lose_returns) {
  TriangleMesh floor;
  floor.add_quad({-90.0, -90.0, -0.6}, {180.0, 0.0, 0.0}, {0.0, 180.0, 0.0}, 0.15);
  LidarOptions o;
  const auto scan = scan_of(floor, Lidar::kRs16, o, SE3{});
  std::array<int, 16> per_ring{};
  for (const std::uint16_t r : scan->ring) ++per_ring[r];
  EXPECT_GT(per_ring[0], 1790);  // -15 deg: 2.3 m away
  EXPECT_LT(per_ring[7], 900);   // -1 deg: 34 m away at grazing incidence
  EXPECT_EQ(per_ring[8], 0);     // above the horizon
  EXPECT_EQ(scan->size() + scan->dropped_range, 28800U);
}

TEST(LidarSensor, edges_give_mixed_points_between_two_surfaces) {
  TriangleMesh mesh = hall();
  mesh.add_box({9.0, 0.0, -3.0}, {0.2, 2.0, 6.0}, 0.0, 0.6);
  LidarOptions o;
  o.noise_m = 0.0;
  o.mixed_fraction = 1.0;
  const auto count_between = [&] {
    const auto scan = scan_of(mesh, Lidar::kRs16, o, SE3{});
    int between = 0;
    for (std::size_t i = 0; i < scan->size(); ++i) {
      const bool before_wall = scan->x_m[i] > 9.15F && scan->x_m[i] < 9.97F;
      between += before_wall && std::abs(scan->y_m[i]) < 3.0F ? 1 : 0;
    }
    return between;
  };
  EXPECT_GT(count_between(), 5);
  o.mixed_fraction = 0.0;
  EXPECT_EQ(count_between(), 0);
}

TEST(Pedestrians, obstruct_rays_and_walk) {
  const Route route({{-20, 0, 0}, {20, 0, 0}}, 0.5);
  Pedestrians people(route, {5, 0, 0}, 1.0, 3);
  people.place_at(0.0);
  const Vec3 before = people.positions()[0];
  Hit hit;
  const Vec3 eye = before + Vec3(0.0, -4.0, 1.2);
  people.cast(eye, Vec3::UnitY(), hit);
  EXPECT_GT(hit.range_m, 0.0F);
  EXPECT_LE(hit.range_m, 3.8F);
  people.place_at(5.0);
  EXPECT_GT((people.positions()[0] - before).norm(), 0.1);
}

TEST(LidarSensor, returns_outside_the_range_limits_are_dropped) {
  LidarOptions o;
  o.noise_m = 0.0;
  o.dropouts = false;
  o.min_range_m = 10.5;
  o.max_range_m = 12.0;
  const auto scan = scan_of(hall(), Lidar::kRs16, o, SE3{});
  ASSERT_GT(scan->size(), 1000U);
  EXPECT_EQ(scan->size() + scan->dropped_range, 28800U);
  for (std::size_t i = 0; i < scan->size(); ++i) {
    const float range = std::hypot(scan->x_m[i], scan->y_m[i], scan->z_m[i]);
    ASSERT_GE(range, 10.498F);
    ASSERT_LE(range, 12.002F);
  }
}

TEST(LidarSensor, points_are_sorted_by_time) {
  for (const Lidar kind : {Lidar::kRs16, Lidar::kHdl64e, Lidar::kOs0_128, Lidar::kLivox}) {
    const auto scan = scan_of(hall(), kind, LidarOptions::of(kind), SE3{});
    ASSERT_GT(scan->size(), 1000U);
    for (std::size_t i = 1; i < scan->size(); ++i) ASSERT_GE(scan->dt_s[i], scan->dt_s[i - 1]);
    EXPECT_LT(scan->dt_s.back(), 0.1F);
    EXPECT_EQ(scan->t_end,
              scan->t_start + Duration::from_s(static_cast<double>(scan->dt_s.back())));
  }
}

TEST(LidarSensor, fraction_of_lost_returns_depends_on_the_reflected_power) {
  // A wall across the view, 10 % white: light of 1 at 70.7 m for a range of 100 m at 20 %.
  TriangleMesh wall;
  wall.add_quad({70.7, -3.0, -3.0}, {0.0, 6.0, 0.0}, {0.0, 0.0, 6.0}, 0.1);
  LidarOptions o;
  int hits = 0;
  int lost = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    LidarSensor lidar(Lidar::kOs1_64, o, static_cast<std::uint64_t>(seed));
    SerialExecutor serial;
    const RayCaster caster(wall);
    const RawScan& raw = lidar.measure_scan(
        0, 0.0, [](double) { return SE3{}; }, caster, MovingScene(), serial);
    for (std::size_t i = 0; i < raw.range_steps.size(); ++i) {
      if (raw.intensity[i] == 0) continue;  // beside the wall
      ++hits;
      lost += raw.range_steps[i] == 0 ? 1 : 0;
    }
  }
  ASSERT_GT(hits, 1500);
  const double fraction = std::exp(-3.0);
  EXPECT_NEAR(lost, hits * fraction, 4.0 * std::sqrt(hits * fraction * (1.0 - fraction)));
}

TEST(MovingScene, a_vehicle_is_a_box_with_a_mast) {
  const VehicleLook look;
  const SE3 T{geometry::rotation_from_rpy(0.0, 0.0, M_PI / 2.0), {5.0, 0.0, 0.25}};
  Hit hit;
  meet_vehicle(look, T, {0.0, 0.0, 0.25}, Vec3::UnitX(), hit);
  EXPECT_NEAR(hit.range_m, 5.0 - 0.22, 1e-6);  // turned by 90 deg: its side
  EXPECT_NEAR(hit.cos_incidence, 1.0, 1e-6);
  Hit mast;
  meet_vehicle(look, T, {0.0, 0.1, 0.5}, Vec3::UnitX(), mast);
  EXPECT_NEAR(mast.range_m, 5.0 - 0.05, 1e-6);
  Hit nearer{1.0F, 1.0F, 0.5F};
  meet_vehicle(look, T, {0.0, 0.0, 0.25}, Vec3::UnitX(), nearer);
  EXPECT_EQ(nearer.range_m, 1.0F);  // hidden behind a wall
  Hit above;
  meet_vehicle(look, T, {0.0, 0.0, 0.9}, Vec3::UnitX(), above);
  EXPECT_EQ(above.range_m, 0.0F);
}

}  // namespace
}  // namespace rali::sim
