#pragma once

// For tests and benchmarks: a box-shaped room, a smooth drive in it, a spinning LiDAR and an IMU,
// all in closed form. Independent of folder `sim`, so that both cannot have the same bug.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "rali/base/rng.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/imu_sample.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::odometry::paper::testing {

struct Room {
  geometry::Vec3 low{-4.0, -3.0, -0.8};
  geometry::Vec3 high{5.0, 3.5, 1.9};

  /// Length of a ray from inside the room to its wall.
  [[nodiscard]] double range_m(const geometry::Vec3& from, const geometry::Vec3& d) const {
    double best_m = 1e9;
    for (int k = 0; k < 3; ++k) {
      if (d(k) > 1e-9) best_m = std::min(best_m, (high(k) - from(k)) / d(k));
      if (d(k) < -1e-9) best_m = std::min(best_m, (low(k) - from(k)) / d(k));
    }
    return best_m;
  }
};

/// Standstill for `rest_s`, then an oscillation in x, y and yaw that starts without a jerk.
struct Drive {
  double rest_s = 1.2;
  double x_m = 0.6, y_m = 0.3, yaw_rad = 0.6;
  double rate_radps = 0.9;

  [[nodiscard]] geometry::SE3 pose(double t_s) const {
    const double u = std::max(0.0, t_s - rest_s) * rate_radps;
    const double swing = u - std::sin(u);  // third order at the start: acceleration from 0
    return {geometry::rotation_from_rpy(0.0, 0.0, yaw_rad * std::sin(0.5 * swing)),
            geometry::Vec3(x_m * (1.0 - std::cos(swing)), y_m * std::sin(swing), 0.0)};
  }

  [[nodiscard]] geometry::Vec3 rate_body_radps(double t_s) const {
    constexpr double kH = 1e-4;
    return geometry::so3_log(pose(t_s - kH).R.transpose() * pose(t_s + kH).R) / (2.0 * kH);
  }
};

struct Lidar {
  int rings = 16;
  int columns = 1800;
  double period_s = 0.1;
  double noise_m = 0.01;
  geometry::SE3 T_body_lidar;
};

/// The scan that ends at end_s; column-major as from a spinning sensor.
inline sensor::LidarScan scan(const Room& room, const Drive& drive, const Lidar& lidar,
                              double end_s, Rng& rng) {
  sensor::LidarScan scan;
  const double start_s = end_s - lidar.period_s;
  scan.t_start = Time::from_s(start_s);
  scan.t_end = Time::from_s(end_s);
  scan.has_point_times = true;
  scan.has_rings = true;
  scan.rings = static_cast<std::uint16_t>(lidar.rings);
  for (int c = 0; c < lidar.columns; ++c) {
    const double dt_s = lidar.period_s * c / (lidar.columns - 1);
    const geometry::SE3 T = drive.pose(start_s + dt_s) * lidar.T_body_lidar;
    const double azimuth = 2.0 * std::numbers::pi * c / lidar.columns;
    for (int ring = 0; ring < lidar.rings; ++ring) {
      const double elevation = (-15.0 + 30.0 * ring / (lidar.rings - 1)) * std::numbers::pi / 180.0;
      const geometry::Vec3 d(std::cos(elevation) * std::cos(azimuth),
                             std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const double r_m = room.range_m(T.p, T.R * d) + lidar.noise_m * rng.normal();
      const Eigen::Vector3f p = (r_m * d).cast<float>();
      scan.push_back(p.x(), p.y(), p.z(), 10.0F, static_cast<float>(dt_s),
                     static_cast<std::uint16_t>(ring));
    }
  }
  return scan;
}

/// What an IMU at T_body_imu measures at t, with constant biases and white noise.
struct Imu {
  geometry::SE3 T_body_imu;
  geometry::Vec3 gyro_bias_radps{0.004, -0.003, 0.005};
  double gyro_noise_radps = 0.005;
  double accel_noise_mps2 = 0.05;

  [[nodiscard]] sensor::ImuSample sample(const Drive& drive, double t_s, Rng& rng) const {
    const auto noise = [&rng](double sd) {
      return geometry::Vec3(sd * rng.normal(), sd * rng.normal(), sd * rng.normal());
    };
    constexpr double kH = 1e-3;
    const auto position = [&](double s) { return (drive.pose(s) * T_body_imu).p; };
    const geometry::Vec3 a =
        (position(t_s + kH) - 2.0 * position(t_s) + position(t_s - kH)) / (kH * kH);
    const geometry::Mat3 R = (drive.pose(t_s) * T_body_imu).R;
    sensor::ImuSample out;
    out.t = Time::from_s(t_s);
    out.gyro_radps = T_body_imu.R.transpose() * drive.rate_body_radps(t_s) + gyro_bias_radps +
                     noise(gyro_noise_radps);
    out.accel_mps2 = R.transpose() * (a + geometry::Vec3(0.0, 0.0, 9.81)) + noise(accel_noise_mps2);
    return out;
  }
};

}  // namespace rali::odometry::paper::testing
