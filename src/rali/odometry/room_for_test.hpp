#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "rali/base/rng.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/imu_sample.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::odometry {

/// An analytic world for tests: a closed room with pillars, a vehicle that is first at standstill
/// and then drives a circle, a spinning LiDAR and an IMU. Has only SE3 in common with the code
/// under test.
struct TestRoom {
  struct Box {
    geometry::Vec3 lo, hi;
  };

  Box walls{{-5.0, -4.0, -1.0}, {7.0, 6.5, 2.6}};
  std::vector<Box> pillars{{{3.0, -2.5, -1.0}, {3.5, -2.0, 2.6}},
                           {{-3.0, 3.5, -1.0}, {-2.4, 4.1, 2.6}},
                           {{4.5, 4.0, -1.0}, {5.5, 4.4, 0.5}}};
  double rest_s = 1.3;  ///< standstill at the start
  double ramp_s = 1.0;  ///< then accelerates
  double speed_mps = 1.0;
  double radius_m = 2.0;
  double stop_s = 1e9;  ///< standstill from then on (abruptly)
  int rings = 16, columns = 300;
  double range_noise_m = 0.01;
  double gyro_noise_radps = 0.005, accel_noise_mps2 = 0.03;  ///< per sample
  geometry::Vec3 gyro_bias_radps{0.004, -0.003, 0.005};
  geometry::SE3 T_body_lidar{geometry::Mat3::Identity(), {0.1, 0.0, 0.2}};
  geometry::SE3 T_body_imu;
  Rng rng{1, "room"};

  static constexpr double kScan_s = 0.1;

  [[nodiscard]] double travel_m(double t_s) const {
    const double tau = std::max(0.0, std::min(t_s, stop_s) - rest_s);
    const double pi = std::numbers::pi;
    const double within = std::min(tau, ramp_s);
    return 0.5 * speed_mps * (within - ramp_s / pi * std::sin(pi * within / ramp_s)) +
           speed_mps * std::max(0.0, tau - ramp_s);
  }

  /// Pose of the body in the world; the identity during the standstill at the start.
  [[nodiscard]] geometry::SE3 pose(double t_s) const {
    const double a = travel_m(t_s) / radius_m;
    geometry::SE3 T;
    T.p = {radius_m * std::sin(a), radius_m * (1.0 - std::cos(a)),
           0.05 * (1.0 - std::cos(2.0 * a))};
    T.R = geometry::rotation_from_rpy(0.03 * (1.0 - std::cos(3.0 * a)),
                                      0.02 * (1.0 - std::cos(2.0 * a)), a);
    return T;
  }

  [[nodiscard]] double range_to(const geometry::Vec3& from, const geometry::Vec3& d) const {
    double range = 1e9;
    for (int k = 0; k < 3; ++k) {
      if (d[k] > 1e-12) range = std::min(range, (walls.hi[k] - from[k]) / d[k]);
      if (d[k] < -1e-12) range = std::min(range, (walls.lo[k] - from[k]) / d[k]);
    }
    for (const Box& box : pillars) {
      double enter = 0.0;
      double leave = 1e9;
      for (int k = 0; k < 3; ++k) {
        const double inverse = 1.0 / (std::abs(d[k]) > 1e-12 ? d[k] : 1e-12);
        const double a = (box.lo[k] - from[k]) * inverse;
        const double b = (box.hi[k] - from[k]) * inverse;
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
      }
      if (enter < leave && enter > 0.0) range = std::min(range, enter);
    }
    return range;
  }

  [[nodiscard]] std::shared_ptr<sensor::LidarScan> scan(double t_start_s) {
    auto out = std::make_shared<sensor::LidarScan>();
    out->reserve(static_cast<std::size_t>(rings * columns));
    out->t_start = Time::from_s(t_start_s);
    out->has_point_times = out->has_rings = true;
    out->rings = static_cast<std::uint16_t>(rings);
    const double pi = std::numbers::pi;
    double dt_s = 0.0;
    for (int c = 0; c < columns; ++c) {
      dt_s = kScan_s * c / columns;
      const geometry::SE3 T = pose(t_start_s + dt_s) * T_body_lidar;
      for (int r = 0; r < rings; ++r) {
        const double elevation = pi / 180.0 * (-30.0 + 40.0 * r / (rings - 1));
        const double azimuth = 2.0 * pi * c / columns;
        const geometry::Vec3 ray(std::cos(elevation) * std::cos(azimuth),
                                 std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
        const double range = range_to(T.p, T.R * ray) + range_noise_m * rng.normal();
        const Eigen::Vector3f p = (range * ray).cast<float>();
        out->push_back(p.x(), p.y(), p.z(), 1.0F, static_cast<float>(dt_s),
                       static_cast<std::uint16_t>(r));
      }
    }
    out->t_end = out->t_start + Duration::from_s(dt_s);
    return out;
  }

  [[nodiscard]] sensor::ImuSample imu(double t_s) {
    constexpr double kStep_s = 1e-3;
    const geometry::SE3 before = pose(t_s - kStep_s) * T_body_imu;
    const geometry::SE3 now = pose(t_s) * T_body_imu;
    const geometry::SE3 after = pose(t_s + kStep_s) * T_body_imu;
    const geometry::Vec3 a = (after.p - 2.0 * now.p + before.p) / (kStep_s * kStep_s);
    const auto noise = [this] { return geometry::Vec3(rng.normal(), rng.normal(), rng.normal()); };
    sensor::ImuSample out;
    out.t = Time::from_s(t_s);
    out.gyro_radps = geometry::so3_log(before.R.transpose() * after.R) / (2.0 * kStep_s) +
                     gyro_bias_radps + gyro_noise_radps * noise();
    out.accel_mps2 =
        now.R.transpose() * (a + geometry::Vec3(0.0, 0.0, 9.81)) + accel_noise_mps2 * noise();
    return out;
  }
};

}  // namespace rali::odometry
