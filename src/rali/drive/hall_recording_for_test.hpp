#pragma once

// A recording for tests of this room and above: a vehicle stands still for a second and then
// wobbles along a furnished hall, with 16 rings at 10 Hz and an IMU at 200 Hz, and faults on
// demand.

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "rali/base/rng.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/io/containers/bag_writer.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/wire/cloud_pack.hpp"
#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::drive::test {

struct HallRecording {
  double duration_s = 14.0;
  double lidar_shift_s = 0.0;  ///< added to the LiDAR's stamps
  double gyro_factor = 1.0;
  double accel_factor = 1.0;
  int gap_from = 0, gap_scans = 0;
  double jump_at_s = 0.0, jump_s = 0.0;  ///< both sensors' stamps jump, the recorder's do not
  double nan_fraction = 0.0;
  geometry::Mat3 R_body_lidar = geometry::Mat3::Identity();
  std::string second_cloud_topic;
  std::string range_topic;  ///< rali_msgs/Range from v1 to v2 at 10 Hz; empty: none

  static constexpr double kStart_s = 1700000000.0;
  static constexpr double kStill_s = 1.5;

  [[nodiscard]] static double moved(double t) { return t < kStill_s ? 0.0 : t - kStill_s; }

  /// Body in the hall; body = IMU.
  [[nodiscard]] static geometry::SE3 pose(double t) {
    const double s = moved(t), ease = s * s / (s + 1.0);
    return {geometry::rotation_from_rpy(0.10 * std::sin(1.3 * ease), 0.08 * std::sin(1.7 * ease),
                                        0.7 * std::sin(0.9 * ease)),
            {5.0 + 0.4 * ease, 6.0 + 0.5 * std::sin(0.5 * ease), 0.8}};
  }

  [[nodiscard]] static geometry::Vec3 rate(double t) {
    constexpr double kStep = 1e-4;
    return geometry::so3_log(pose(t - kStep).R.transpose() * pose(t + kStep).R) / (2.0 * kStep);
  }

  [[nodiscard]] static geometry::Vec3 force(double t) {
    constexpr double kStep = 1e-3;
    const geometry::Vec3 a =
        (pose(t + kStep).p - 2.0 * pose(t).p + pose(t - kStep).p) / (kStep * kStep);
    return pose(t).R.transpose() * (a + geometry::Vec3{0.0, 0.0, 9.81});
  }

  struct Box {
    geometry::Vec3 low, high;
  };

  /// Distance to the first box from outside, or to the walls of the hall from inside.
  [[nodiscard]] static double distance(const geometry::Vec3& p, const geometry::Vec3& d) {
    const auto slabs = [&](const Box& box) {
      double enter = -std::numeric_limits<double>::infinity();
      double leave = std::numeric_limits<double>::infinity();
      for (int k = 0; k < 3; ++k) {
        const double a = (box.low(k) - p(k)) / d(k), b = (box.high(k) - p(k)) / d(k);
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
      }
      return std::pair{enter, leave};
    };
    double nearest = slabs({{0, 0, 0}, {22, 13, 5}}).second;
    for (const Box& box : {Box{{9, 9, 0}, {11, 12, 2}}, Box{{14, 1, 0}, {15, 3, 3}},
                           Box{{2, 1, 0}, {3, 2, 4}}, Box{{18, 8, 0}, {20, 9, 1.2}}}) {
      const auto [enter, leave] = slabs(box);
      if (enter > 0.0 && enter < leave) nearest = std::min(nearest, enter);
    }
    return nearest;
  }

  [[nodiscard]] sensor::LidarScan scan(int index, Rng& rng) const {
    sensor::LidarScan scan;
    const double begin = 0.1 * index;
    constexpr int kColumns = 400;
    for (int column = 0; column < kColumns; ++column) {
      const double dt = 0.1 * column / kColumns;
      const geometry::SE3 T = pose(begin + dt);
      const double azimuth = std::numbers::pi - 2.0 * std::numbers::pi * column / kColumns;
      for (int ring = 0; ring < 16; ++ring) {
        const double elevation = (-15.0 + 2.0 * ring) * std::numbers::pi / 180.0;
        const geometry::Vec3 d{std::cos(elevation) * std::cos(azimuth),
                               std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
        const double range = distance(T.p, T.R * (R_body_lidar * d)) + 0.01 * rng.normal();
        const geometry::Vec3f p = (range * d).cast<float>();
        const bool lost = rng.uniform() < nan_fraction;
        const float x = lost ? std::numeric_limits<float>::quiet_NaN() : p.x();
        scan.push_back(x, p.y(), p.z(), 10.0F, static_cast<float>(dt),
                       static_cast<std::uint16_t>(ring));
      }
    }
    scan.t_start = Time::from_s(kStart_s + begin) + Duration::from_s(lidar_shift_s);
    scan.t_end = scan.t_start + Duration::from_s(0.1);
    scan.has_point_times = scan.has_rings = true;
    scan.rings = 16;
    return scan;
  }

  [[nodiscard]] wire::ImuMessage imu(double t, Rng& rng) const {
    wire::ImuMessage message;
    const geometry::Vec3 n{rng.normal(), rng.normal(), rng.normal()};
    const geometry::Vec3 m{rng.normal(), rng.normal(), rng.normal()};
    message.frame_id = "imu";
    message.sample = {Time::from_s(kStart_s) + Duration::from_s(t),
                      gyro_factor * (rate(t) + 0.002 * n), accel_factor * (force(t) + 0.02 * m)};
    return message;
  }

  [[nodiscard]] static wire::RangeMessage range_at(Time now, double t) {
    wire::RangeMessage message;
    message.stamp = now;
    message.from = "v1";
    message.to = "v2";
    message.range_m = 5.0 + 0.1 * t;
    return message;
  }

  /// Writes a ROS 1 bag; returns its path.
  [[nodiscard]] std::string write(const std::string& path) const;
};

inline std::uint32_t connect(io::BagWriter& bag, const std::string& topic,
                             const std::string& type) {
  return bag
      .add_connection(topic, type, std::string(wire::message_md5(type)),
                      wire::message_definition(type, wire::Encoding::kRos1))
      .value();
}

inline std::string HallRecording::write(const std::string& path) const {
  io::MemorySink sink;
  io::BagWriter bag(sink, io::BagWriter::Options{});
  const auto clouds = connect(bag, "/points", "sensor_msgs/PointCloud2");
  const auto other = second_cloud_topic.empty()
                         ? clouds
                         : connect(bag, second_cloud_topic, "sensor_msgs/PointCloud2");
  const auto inertial = connect(bag, "/imu/data", "sensor_msgs/Imu");
  const auto ranges = range_topic.empty() ? inertial : connect(bag, range_topic, "rali_msgs/Range");
  Rng lidar_noise(1, "lidar"), imu_noise(1, "imu");
  bool whole = true;
  for (int tick = 0; tick < static_cast<int>(duration_s * 200.0); ++tick) {
    const double t = tick / 200.0;
    const Time now = Time::from_s(kStart_s) + Duration::from_s(t + 0.001);
    const Duration jumped = Duration::from_s(jump_s != 0.0 && t > jump_at_s ? jump_s : 0.0);
    wire::ImuMessage message_imu = imu(t, imu_noise);
    message_imu.sample.t = message_imu.sample.t + jumped;
    const auto sample = wire::encode(message_imu, wire::Encoding::kRos1);
    whole = whole && bag.write(inertial, now, sample).has_value();
    if (tick % 20 != 0 || tick == 0) continue;
    if (!range_topic.empty()) {
      const auto range = wire::encode(range_at(now, t), wire::Encoding::kRos1);
      whole = whole && bag.write(ranges, now, range).has_value();
    }
    const int index = tick / 20 - 1;
    if (index >= gap_from && index < gap_from + gap_scans) continue;
    sensor::LidarScan scan = this->scan(index, lidar_noise);
    scan.t_start = scan.t_start + jumped;
    scan.t_end = scan.t_end + jumped;
    const wire::PackedCloud packed = wire::pack_cloud(scan, "lidar", wire::CloudStyle::kVelodyne);
    const auto message = wire::encode(packed.view, wire::Encoding::kRos1);
    whole = whole && bag.write(clouds, now, message).has_value();
    if (!second_cloud_topic.empty()) whole = whole && bag.write(other, now, message).has_value();
  }
  whole = whole && bag.close().has_value() &&
          io::write_file_atomic(path, std::span<const std::byte>(sink.bytes())).has_value();
  return whole ? path : std::string();
}

}  // namespace rali::drive::test
