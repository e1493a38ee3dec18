#pragma once

#include "rali/wire/byte_writer.hpp"
#include "rali/wire/cloud_format.hpp"
#include "rali/wire/messages.hpp"

/// Encodes values as the bytes of one message: CDR (XCDR1) for session.mcap and rosbag2, ROS 1 for
/// bags. The encoding must be kRos1 or kCdr. Texts of the definitions: definitions.hpp.
namespace rali::wire {

/// sensor_msgs/PointCloud2. Padding (up to 64 bytes) that `cloud.data` lacks after the last point
/// is filled with zeros, so that a decoded Livox message can be written.
[[nodiscard]] Bytes encode(const CloudView& cloud, Encoding encoding, bool big_endian = false);

/// sensor_msgs/Imu without orientation (orientation_covariance[0] = -1, by REP-145).
[[nodiscard]] Bytes encode(const ImuMessage& imu, Encoding encoding, bool big_endian = false);

/// tf2_msgs/TFMessage.
[[nodiscard]] Bytes encode(const TfMessage& tf, Encoding encoding, bool big_endian = false);

/// geometry_msgs/PoseStamped.
[[nodiscard]] Bytes encode(const PoseStamped& pose, Encoding encoding, bool big_endian = false);

/// nav_msgs/Odometry; the velocity's covariance is unknown: zeros.
[[nodiscard]] Bytes encode(const Odometry& odometry, Encoding encoding, bool big_endian = false);

/// nav_msgs/OccupancyGrid. `cells` has width * height entries.
[[nodiscard]] Bytes encode(const GridMessage& grid, Encoding encoding, bool big_endian = false);

/// nav_msgs/Path.
[[nodiscard]] Bytes encode(const Path& path, Encoding encoding, bool big_endian = false);

/// diagnostic_msgs/DiagnosticArray.
[[nodiscard]] Bytes encode(const DiagnosticArray& array, Encoding encoding,
                           bool big_endian = false);

/// visualization_msgs/Marker, as ROS 1 Noetic and ROS 2 Humble (and later) define it.
[[nodiscard]] Bytes encode(const Marker& marker, Encoding encoding, bool big_endian = false);

/// visualization_msgs/MarkerArray.
[[nodiscard]] Bytes encode(const MarkerArray& markers, Encoding encoding, bool big_endian = false);

/// rali_msgs/Range.
[[nodiscard]] Bytes encode(const RangeMessage& range, Encoding encoding, bool big_endian = false);

/// Livox CustomMsg.
[[nodiscard]] Bytes encode(const LivoxCustom& cloud, Encoding encoding, bool big_endian = false);

/// std_msgs/String.
[[nodiscard]] Bytes encode_string(std::string_view text, Encoding encoding,
                                  bool big_endian = false);

}  // namespace rali::wire
