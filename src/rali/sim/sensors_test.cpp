#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "rali/sim/imu_model.hpp"
#include "rali/sim/lidar_sensor.hpp"

namespace rali::sim {
namespace {

using geometry::SE3;
using geometry::Vec3;

double degrees(double rad) { return rad * 180.0 / M_PI; }

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
  const RawSweep& raw = lidar.measure_sweep(
      0, 0.0, [&](double) { return T; }, caster, MovingScene(), serial);
  return expand(raw, lidar.model(), options.resolution_m, Time::from_ns(1));
}

TEST(LidarModel, ring_angles_are_those_of_the_data_sheets) {
  const std::vector<double> rs16 = LidarModel(Lidar::kRs16).elevations_rad();
  ASSERT_EQ(rs16.size(), 16U);
  EXPECT_NEAR(degrees(rs16.front()), -15.0, 1e-9);
  EXPECT_NEAR(degrees(rs16[8]), 1.0, 1e-9);
  EXPECT_NEAR(degrees(rs16.back()), 15.0, 1e-9);
  const std::vector<double> hdl32 = LidarModel(Lidar::kHdl32e).elevations_rad();
  EXPECT_NEAR(degrees(hdl32[1] - hdl32[0]), 1.3335, 1e-3);
  EXPECT_NEAR(degrees(hdl32.back()), 10.67, 1e-9);
  const std::vector<double> hdl64 = LidarModel(Lidar::kHdl64e).elevations_rad();
  ASSERT_EQ(hdl64.size(), 64U);
  EXPECT_NEAR(degrees(hdl64.front()), -24.33, 1e-9);
  EXPECT_NEAR(degrees(hdl64.back()), 2.0, 0.01);
  EXPECT_EQ(LidarModel(Lidar::kOs0_128).elevations_rad().size(), 128U);
}

TEST(LidarSensor, points_of_a_ring_stand_at_its_angle_and_on_the_wall) {
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

TEST(LidarSensor, range_noise_has_the_stated_spread_and_no_bias) {
  LidarOptions o;
  o.mixed_share = 0.0;
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

TEST(LidarSensor, edges_give_some_points_between_the_surfaces) {
  TriangleMesh mesh = hall();
  mesh.add_box({9.0, 0.0, -3.0}, {0.2, 2.0, 6.0}, 0.0, 0.6);
  LidarOptions o;
  o.noise_m = 0.0;
  o.mixed_share = 1.0;
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
  o.mixed_share = 0.0;
  EXPECT_EQ(count_between(), 0);
}

TEST(LidarSensor, a_rosette_does_not_repeat_itself) {
  const LidarModel livox(Lidar::kLivox);
  const Vec3 first = livox.beam(0, 100, 0).cast<double>();
  const Vec3 later = livox.beam(0, 100, 1).cast<double>();
  EXPECT_NEAR(first.norm(), 1.0, 1e-6);
  EXPECT_GT((first - later).norm(), 0.01);
  for (int firing = 0; firing < 4000; firing += 7) {
    EXPECT_GT(livox.beam(3, firing, 5).x(), 0.8F);  // within 36 deg of the axis
  }
}

TEST(Pedestrians, stand_in_the_way_of_rays_and_walk) {
  const Route route({{-20, 0, 0}, {20, 0, 0}}, 0.5);
  Pedestrians people(route, 5, 1.0, 3);
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

TEST(ImuModel, at_rest_the_specific_force_points_up) {
  const sensor::ImuSample s = ideal_imu(Time{}, MotionState{}, SE3{});
  EXPECT_NEAR((s.accel_mps2 - Vec3(0.0, 0.0, 9.81)).norm(), 0.0, 1e-12);
  EXPECT_EQ(s.gyro_radps.norm(), 0.0);
}

TEST(ImuModel, turning_on_the_spot_pulls_a_lever_inwards) {
  MotionState state;
  state.omega_body_radps = {0.0, 0.0, 2.0};
  const sensor::ImuSample s =
      ideal_imu(Time{}, state, {geometry::Mat3::Identity(), {0.5, 0.0, 0.0}});
  EXPECT_NEAR(s.accel_mps2.x(), -2.0, 1e-12);  // -w^2 r
}

TEST(ImuModel, white_noise_follows_the_density) {
  ImuOptions o = ImuOptions::ideal();
  o.gyro_radps_rthz = 1.5e-3;
  o.accel_mps2_rthz = 1e-2;
  ImuModel imu(o, 1);
  double gyro = 0.0;
  double accel = 0.0;
  constexpr int kCount = 4000;
  for (int i = 0; i < kCount; ++i) {
    const sensor::ImuSample s = imu.measure({}, 0.0);
    gyro += s.gyro_radps.squaredNorm() / (3.0 * kCount);
    accel += s.accel_mps2.squaredNorm() / (3.0 * kCount);
  }
  EXPECT_NEAR(std::sqrt(gyro), 1.5e-3 * std::sqrt(200.0), 6e-4);
  EXPECT_NEAR(std::sqrt(accel), 1e-2 * std::sqrt(200.0), 4e-3);
}

TEST(ImuModel, vibration_grows_with_speed_and_has_the_stated_spread) {
  ImuOptions o = ImuOptions::ideal();
  o.vibration_accel_mps2 = 0.3;
  ImuModel imu(o, 1);
  double squares = 0.0;
  constexpr int kCount = 8000;
  for (int i = 0; i < kCount; ++i) {
    squares += imu.measure({}, 2.0).accel_mps2.squaredNorm() / (3.0 * kCount);
  }
  EXPECT_NEAR(std::sqrt(squares), 0.6, 0.03);
  EXPECT_EQ(imu.measure({}, 0.0).accel_mps2.norm(), 0.0);
}

TEST(ImuModel, faults_of_drivers_are_applied) {
  ImuOptions o = ImuOptions::ideal();
  o.accel_in_g = true;
  o.gyro_in_degps = true;
  o.time_offset_s = 0.02;
  o.scale_error = 0.01;
  o.gyro_limit_radps = 1.0;
  sensor::ImuSample ideal;
  ideal.t = Time::from_s(1.0);
  ideal.accel_mps2 = {0.0, 0.0, 9.81};
  ideal.gyro_radps = {3.0, 0.5, 0.0};
  const sensor::ImuSample s = ImuModel(o, 1).measure(ideal, 0.0);
  EXPECT_NEAR(s.accel_mps2.z(), 1.01, 1e-12);
  EXPECT_NEAR(s.gyro_radps.x(), degrees(1.0), 1e-9);  // saturated
  EXPECT_NEAR(s.gyro_radps.y(), degrees(0.505), 1e-9);
  EXPECT_EQ(s.t, Time::from_s(1.02));
}

}  // namespace
}  // namespace rali::sim
