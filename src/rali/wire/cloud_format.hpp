#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/sensor/lidar_scan.hpp"
#include "rali/wire/encoding.hpp"

namespace rali::wire {

/// PointField datatypes of sensor_msgs (values as on the wire).
enum class FieldType : std::uint8_t {
  kInt8 = 1, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64
};

struct CloudField {
  std::string name;
  std::uint32_t offset = 0;
  FieldType type = FieldType::kFloat32;
  std::uint32_t count = 1;
};

/// A parsed PointCloud2 (or Livox CustomMsg, or a PCD/PLY/KITTI file brought to the same shape).
/// `data` points into the message.
struct CloudView {
  Time stamp;
  std::string frame_id;
  std::uint32_t height = 0, width = 0, point_step = 0, row_step = 0;
  bool big_endian = false;
  std::vector<CloudField> fields;
  std::span<const std::byte> data;
};

/// How the time of a point is stored.
enum class PointTime {
  kAuto, kAbsoluteS, kAbsoluteNs, kRelativeS, kRelativeMs, kRelativeUs, kRelativeNs, kAzimuth, kNone
};

/// Which end of the sweep the header stamp names (with relative times).
enum class HeaderStamp { kAuto, kStart, kEnd };

/// What the user fixed; the rest is found from the data (product.md section 3, vehicles.*.lidar).
struct CloudFormatOptions {
  std::string model = "auto";
  PointTime point_time = PointTime::kAuto;
  HeaderStamp header_stamp = HeaderStamp::kAuto;
  bool deskewed = false;
  std::array<double, 2> range_m = {0.4, 100.0};
  std::optional<std::array<double, 6>> self_box_lidar_m;  ///< xmin,xmax,ymin,ymax,zmin,zmax
  double sweep_period_s = 0.1;  ///< for azimuth time, when no model or stamps tell
};

/// How to read the clouds of one topic: decided once, from the first clouds, and printed.
struct CloudFormat {
  int x = -1, y = -1, z = -1, intensity = -1, ring = -1, time = -1;  ///< index in fields, -1 = none
  PointTime point_time = PointTime::kNone;
  HeaderStamp header_stamp = HeaderStamp::kStart;
  double time_scale_s = 1.0;       ///< seconds per unit of the time field
  bool rings_from_elevation = false;
  std::vector<float> ring_elevations_rad;  ///< ascending; for rings_from_elevation
  std::uint16_t rings = 0;
  std::string model;               ///< name in sensor/lidar_models or "generic"
  bool azimuth_clockwise = true;   ///< seen from above, for azimuth time
  double sweep_period_s = 0.1;
  std::string summary;             ///< one line for people: what was decided and why
  FindingList findings;
};

}  // namespace rali::wire
