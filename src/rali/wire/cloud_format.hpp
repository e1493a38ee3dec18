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
#include "rali/base/settings.hpp"
#include "rali/base/time.hpp"
#include "rali/sensor/lidar_scan.hpp"
#include "rali/wire/encoding.hpp"

namespace rali::wire {

/// PointField datatypes of sensor_msgs (values as on the wire).
enum class FieldType : std::uint8_t {
  kInt8 = 1,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat32,
  kFloat64
};

struct CloudField {
  std::string name;
  std::uint32_t offset = 0;
  FieldType type = FieldType::kFloat32;
  std::uint32_t count = 1;
};

/// A parsed PointCloud2 (or Livox CustomMsg, or a PCD/PLY/KITTI file converted to the same form).
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
  kAuto,
  kAbsoluteS,
  kAbsoluteNs,
  kRelativeS,
  kRelativeMs,
  kRelativeUs,
  kRelativeNs,
  kAzimuth,
  kNone
};
inline constexpr ChoiceNames<9> kPointTimeNames{"auto",        "absolute_s",  "absolute_ns",
                                                "relative_s",  "relative_ms", "relative_us",
                                                "relative_ns", "azimuth",     "none"};

/// Which end of the scan the header stamp refers to (with relative times).
enum class HeaderStamp { kAuto, kStart, kEnd };
inline constexpr ChoiceNames<3> kHeaderStampNames{"auto", "start", "end"};

/// Source of a point's laser index.
enum class RingFrom { kNone, kField, kElevation, kRow, kColumn };

/// Treatment of a second return of the same laser pulse: keep one of the two, both, the one with
/// the larger intensity, or the farther one.
enum class Returns { kOne, kAll, kStrongest, kLast };

/// Options set by the user; the rest is derived from the data (product.md section 3,
/// vehicles.*.lidar).
struct CloudFormatOptions {
  std::string model = "auto";
  PointTime point_time = PointTime::kAuto;
  HeaderStamp header_stamp = HeaderStamp::kAuto;
  bool deskewed = false;
  std::array<double, 2> range_m = {0.4, 100.0};
  std::optional<std::array<double, 6>> self_box_lidar_m;  ///< xmin,xmax,ymin,ymax,zmin,zmax
  double scan_period_s = 0.1;  ///< for azimuth time, if neither model nor stamps give it
  Returns returns = Returns::kOne;
};

/// How to read the clouds of one topic: decided once, from the first clouds, and printed.
struct CloudFormat {
  int x = -1, y = -1, z = -1, intensity = -1, ring = -1, time = -1;  ///< index in fields, -1 = none
  PointTime point_time = PointTime::kNone;
  HeaderStamp header_stamp = HeaderStamp::kStart;
  double time_scale_s = 1.0;  ///< seconds per unit of the time field
  bool rings_from_elevation = false;
  std::vector<float> ring_elevations_rad;  ///< ascending; for rings_from_elevation
  std::uint16_t rings = 0;
  std::string model;              ///< name in sensor/lidar_models or "generic"
  bool azimuth_clockwise = true;  ///< seen from above, for azimuth time
  double scan_period_s = 0.1;
  double time_shift_s = 0.0;      ///< added to relative times: a header stamp the user fixed
  bool anchor_to_header = false;  ///< absolute times run on another clock: first point = header
  double span_s = 0.0;            ///< of the point times of one scan, as measured
  double azimuth_start_rad = 3.14159265358979323846;  ///< where azimuth time starts: the rear
  RingFrom ring_from = RingFrom::kNone;
  int return_type = -1;               ///< index in fields, -1 = none
  std::uint32_t returns_dropped = 0;  ///< bit v set: points with return_type v are left out
  std::string summary;                ///< one line for people: the decisions and their reasons
  FindingList findings;
};

/// Decides how to read the clouds of one topic from its first 1 to 10 clouds, by their values,
/// because a field named 't' may hold anything. Anomalies become a Finding D02 (point times), D03
/// (header stamp), D05 (points without values) or D06 (rings). With several clouds the interval of
/// their stamps gives the scan period.
///
/// Errors (kInput): no cloud, no x y z, a layout that contradicts itself, a time field set in the
/// options that does not exist. Empty clouds are skipped; if all are empty, kNoAnswer.
[[nodiscard]] Result<CloudFormat> decide_cloud_format(std::span<const CloudView> clouds,
                                                      const CloudFormatOptions& options);

/// Converts one cloud to a scan in the LiDAR frame. Points that are not finite, at zero, out of
/// range, within the self box or with a time more than 1.5 scan periods from the others are dropped
/// and counted. `out` is overwritten; its memory is reused. Fields are read by the index in
/// `format`: a cloud whose field list changed is an Error (kInput), decide again.
[[nodiscard]] Status decode_cloud(const CloudView& cloud, const CloudFormat& format,
                                  const CloudFormatOptions& options, sensor::LidarScan& out);

}  // namespace rali::wire
