#pragma once

#include <cmath>

#include "rali/base/rng.hpp"
#include "rali/fleet/facts/facts.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::fleet {

inline geometry::SE3 random_pose(Rng& rng) {
  const geometry::Vec3 turn(rng.normal(), rng.normal(), rng.normal());
  return {geometry::so3_exp(turn),
          100.0 * geometry::Vec3(rng.normal(), rng.normal(), rng.normal())};
}

template <int N>
Eigen::Matrix<double, N, N> random_covariance(Rng& rng) {
  Eigen::Matrix<double, N, N> root;
  for (int i = 0; i < N * N; ++i) root(i / N, i % N) = 0.01 * rng.normal();
  return root * root.transpose();
}

inline geometry::Vec3 random_vector(Rng& rng) { return {rng.normal(), rng.normal(), rng.normal()}; }

inline Increment random_increment(Rng& rng) {
  Increment step;
  step.node = static_cast<std::uint32_t>(rng.below(100000));
  if (rng.below(2) == 0) step.keyframe = static_cast<std::uint32_t>(rng.below(10000));
  step.degenerate = rng.below(2) == 0;
  step.levelled = true;
  step.T_odom_body = random_pose(rng);
  step.v_odom_mps = random_vector(rng);
  step.gyro_bias_radps = 0.01 * random_vector(rng);
  step.accel_bias_mps2 = 0.1 * random_vector(rng);
  step.g_odom_mps2 = geometry::Vec3(0.01, -0.02, -9.81);
  step.force_sigma_mps2 = rng.below(2) == 0 ? rng.uniform(1e-4, 1e-1) : 0.0;
  step.level_sigma_rad = rng.below(2) == 0 ? rng.uniform(1e-4, 1e-1) : 0.0;
  step.covariance = random_covariance<6>(rng);
  step.lidar_information = 1e8 * random_covariance<6>(rng);
  step.inertial.emplace();
  graph::InertialFactor& f = *step.inertial;
  f.duration_s = rng.uniform(0.1, 2.0);
  f.dR = random_pose(rng).R;
  f.dv_mps = random_vector(rng);
  f.dp_m = random_vector(rng);
  f.gyro_bias_radps = 0.01 * random_vector(rng);
  f.accel_bias_mps2 = 0.1 * random_vector(rng);
  for (geometry::Mat3* m : {&f.d_rotation_d_gyro, &f.d_velocity_d_gyro, &f.d_velocity_d_accel,
                            &f.d_position_d_gyro, &f.d_position_d_accel}) {
    for (int k = 0; k < 9; ++k) (*m)(k / 3, k % 3) = rng.normal();
  }
  f.covariance = random_covariance<9>(rng);
  f.g_odom_mps2 = rng.below(2) == 0 ? step.g_odom_mps2 : geometry::Vec3(0.0, 0.0, -9.8);
  f.T_body_imu = random_pose(rng);
  return step;
}

/// Ranges to `peers` vehicles at 20 Hz each, from a vehicle that drives a curve at 1 m/s.
inline RangeBlock random_ranges(Rng& rng, VehicleId self, int peers, int count) {
  RangeBlock block;
  for (int k = 0; k < count; ++k) {
    const double s = 0.05 / peers * k;
    RangeEntry entry;
    entry.t = Time::from_ns(1700000000000000000) + Duration::from_ns(1000 * std::llround(1e6 * s));
    entry.from = self;
    entry.to = VehicleId{static_cast<std::uint16_t>(self.value + 1 + k % peers)};
    entry.range_m = 20.0 + s + 0.07 * rng.normal();
    entry.sigma_m = 0.1;
    entry.T_odom_body.R = geometry::rotation_from_rpy(0.01 * std::sin(3.0 * s), 0.0, 0.3 * s);
    entry.T_odom_body.p = {57.0 + s, 13.0 + 0.15 * s * s, 0.2};
    block.ranges.push_back(entry);
  }
  return block;
}

inline KeyframePoints random_points(Rng& rng, std::size_t n, bool with_intensity) {
  KeyframePoints points;
  PointArrays arrays;
  points.keyframe = 17;
  points.T_body_lidar = random_pose(rng);
  for (std::size_t k = 0; k < n; ++k) {
    const auto x = static_cast<float>(rng.uniform(-50.0, 50.0));
    const auto y = static_cast<float>(rng.uniform(-2.0, 2.0));
    arrays.push_back(x, y, static_cast<float>(rng.uniform(-1.0, 2.0)));
    if (with_intensity) arrays.intensity.push_back(static_cast<std::uint8_t>(rng.below(256)));
  }
  points.points = PackedPoints(arrays);
  return points;
}

inline Loop random_loop(Rng& rng) {
  Loop loop;
  loop.from = {VehicleId{1}, 12};
  loop.to = {VehicleId{2}, 345};
  loop.T_from_to = random_pose(rng);
  loop.information = 1e8 * random_covariance<6>(rng);
  loop.overlap = rng.uniform();
  loop.rms_m = 0.03;
  loop.to_epoch = 4;
  return loop;
}

/// A body of each kind by `which`, 0 to 6.
inline FactBody random_body(Rng& rng, int which, VehicleId author) {
  switch (which) {
    case 0:
      return EpochStart{"rover 1", {random_vector(rng), random_vector(rng)}};
    case 1:
      return random_increment(rng);
    case 2:
      return random_ranges(rng, author, 3, 60);
    case 3:
      return random_points(rng, 500, false);
    case 4: {
      KeyframePoints points = random_points(rng, 300, true);
      points.refinement = true;
      return points;
    }
    case 5:
      return random_loop(rng);
    default:
      return Increment{};
  }
}

inline constexpr int kBodies = 7;

}  // namespace rali::fleet
