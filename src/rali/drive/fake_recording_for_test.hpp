#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "rali/drive/reported_source.hpp"
#include "rali/io/containers/mcap_writer.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/wire/cloud_pack.hpp"
#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::drive {

/// A cloud or an inertial sample, with header and record time.
struct Message {
  bool cloud = false;
  double header_s = 0.0, record_s = 0.0;
};

/// For tests: an MCAP of a vehicle at standstill on a floor: 10 Hz scans, 100 Hz inertial data.
class FakeRecording {
 public:
  explicit FakeRecording(std::size_t chunk_bytes = 1U << 20)
      : writer_(sink_, {"ros2", io::Compression::kZstd, chunk_bytes}) {
    cloud_ = channel("/points", "sensor_msgs/msg/PointCloud2");
    imu_ = channel("/imu", "sensor_msgs/msg/Imu");
  }

  void add_imu(double header_s, double record_s) {
    wire::ImuMessage message;
    message.frame_id = "imu";
    message.sample.t = Time::from_s(header_s);
    message.sample.accel_mps2 = {0.0, 0.0, accel};
    message.sample.gyro_radps = {0.001, 0.0, 0.0};
    write(imu_, record_s, wire::encode(message, wire::Encoding::kCdr));
  }

  void add(const Message& m) {
    m.cloud ? add_cloud(m.header_s, m.record_s) : add_imu(m.header_s, m.record_s);
  }

  /// A scan that ends at header_s + 0.09; the header has its start.
  void add_cloud(double header_s, double record_s) {
    sensor::LidarScan scan;
    scan.t_start = Time::from_s(header_s);
    scan.t_end = Time::from_s(header_s + 0.09);
    scan.has_point_times = scan.has_rings = true;
    scan.rings = 16;
    for (int i = 0; i < 300; ++i) {
      for (int ring = 0; ring < 12; ++ring) {
        const double a = i * 2.0 * 3.14159265 / 300.0;
        const double r = nan ? std::nan("") : 3.0 + 0.3 * ring;
        scan.push_back(static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)),
                       -1.0F, 1.0F, static_cast<float>(i) * 3e-4F,
                       static_cast<std::uint16_t>(ring));
      }
    }
    const wire::PackedCloud cloud = wire::pack_cloud(scan, "lidar", wire::CloudStyle::kVelodyne);
    write(cloud_, record_s, wire::encode(cloud.view, wire::Encoding::kCdr));
  }

  /// v1 to v2 on /ranges; with a stamp of 0 the record time is used.
  void add_range(double header_s, double record_s) {
    if (!ranges_) ranges_ = channel("/ranges", "rali_msgs/msg/Range");
    wire::RangeMessage message;
    message.stamp = Time::from_s(header_s);
    message.from = "v1";
    message.to = "v2";
    message.range_m = 7.5;
    write(*ranges_, record_s, wire::encode(message, wire::Encoding::kCdr));
  }

  /// Stamps start at `t0`; `warp` may change the headers of either sensor.
  template <class Warp>
  void add_seconds(double t0, double seconds, Warp warp) {
    const int steps = static_cast<int>(std::lround(seconds * 100.0));
    for (int i = 0; i < steps; ++i) {
      const double t = t0 + 0.01 * i;
      add_imu(warp(t, true), t + 0.002);
      if (i % 10 == 9) add_cloud(warp(t - 0.09, false), t + 0.005);
    }
  }

  std::string save(const io::TestFolder& folder, const std::string& name = "v1.mcap") {
    EXPECT_TRUE(writer_.close());
    const auto& b = sink_.bytes();
    return folder.write(name, {reinterpret_cast<const char*>(b.data()), b.size()});
  }

  double accel = 9.81;
  bool nan = false;  ///< of all points of the scans that follow

 private:
  std::uint16_t channel(const std::string& topic, const std::string& type) {
    const auto schema =
        writer_.add_schema(type, "ros2msg", wire::message_definition(type, wire::Encoding::kCdr));
    return *writer_.add_channel(*schema, topic, "cdr");
  }

  void write(std::uint16_t channel, double record_s, const wire::Bytes& bytes) {
    const Time t = Time::from_s(record_s);
    EXPECT_TRUE(writer_.write(channel, t, t, bytes));
  }

  io::MemorySink sink_;
  io::McapWriter writer_;
  std::uint16_t cloud_ = 0, imu_ = 0;
  std::optional<std::uint16_t> ranges_;
};

inline double as_is(double t, bool) { return t; }

struct Drained {
  std::size_t scans = 0, imu = 0;
  std::vector<Time> ranges;
  bool ordered = true;
  Time first, last;
  Time last_scan, first_scan;
};

inline Drained drain(ReportedSource& source) {
  Drained d;
  bool any = false;
  while (true) {
    const auto event = source.next();
    EXPECT_TRUE(event);
    if (!event || !*event) return d;
    Time t;
    if (const auto* imu = std::get_if<sensor::ImuSample>(&**event)) {
      t = imu->t;
      ++d.imu;
    } else if (const auto* range = std::get_if<sensor::RangeSample>(&**event)) {
      t = range->t;
      d.ranges.push_back(t);
    } else {
      t = std::get<std::shared_ptr<const sensor::LidarScan>>(**event)->t_end;
      if (d.scans++ == 0) d.first_scan = t;
      d.last_scan = t;
    }
    if (!any) d.first = t;
    d.ordered &= !any || t >= d.last;
    d.last = t;
    any = true;
  }
}

inline bool has(const FindingList& findings, const std::string& id) {
  for (const Finding& f : findings) {
    if (f.id == id && f.severity != Severity::kInfo) return true;
  }
  return false;
}

}  // namespace rali::drive
