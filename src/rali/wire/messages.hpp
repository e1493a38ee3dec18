#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/imu_sample.hpp"
#include "rali/wire/byte_writer.hpp"
#include "rali/wire/cloud_format.hpp"

/// Messages as values: output of the decoders and input of the encoders. One struct serves ROS 1
/// and ROS 2. Names of members follow the message definitions, with units where they are fixed.
namespace rali::wire {

/// sensor_msgs/Imu; covariances and orientation are not kept.
struct ImuMessage {
  sensor::ImuSample sample;  ///< units as sent: the doctor detects g and deg/s by value
  std::string frame_id;
};

/// geometry_msgs/TransformStamped; p_frame = T_frame_child * p_child.
struct TransformStamped {
  Time stamp;
  std::string frame_id, child_frame_id;
  geometry::SE3 T_frame_child;
};

/// tf2_msgs/TFMessage.
struct TfMessage {
  std::vector<TransformStamped> transforms;
  std::uint32_t refused = 0;  ///< without a rotation (quaternion 0 or NaN): left out
};

/// geometry_msgs/PoseStamped: pose of the body in frame_id.
struct PoseStamped {
  Time stamp;
  std::string frame_id;
  geometry::SE3 T_frame_body;
};

/// nav_msgs/Odometry: pose of the child in frame_id, velocity in the child.
struct Odometry {
  Time stamp;
  std::string frame_id, child_frame_id;
  geometry::SE3 T_frame_child;
  /// x y z rx ry rz, rotations about the fixed axes of frame_id.
  geometry::Mat6 pose_covariance = geometry::Mat6::Zero();
  geometry::Vec3 v_child_mps = geometry::Vec3::Zero();
  geometry::Vec3 omega_child_radps = geometry::Vec3::Zero();
};

/// nav_msgs/OccupancyGrid: rows from the smallest y; -1 unknown, 0 free, 100 occupied.
struct GridMessage {
  Time stamp;
  std::string frame_id;
  float cell_m = 0.05F;
  std::uint32_t width = 0, height = 0;
  geometry::Vec2 origin_m = geometry::Vec2::Zero();  ///< corner of the lower-left cell
  std::vector<std::int8_t> cells;
};

/// nav_msgs/Path.
struct Path {
  Time stamp;
  std::string frame_id;
  std::vector<PoseStamped> poses;
};

/// diagnostic_msgs/DiagnosticStatus.
struct DiagnosticStatus {
  enum Level : std::uint8_t { kOk = 0, kWarn, kError, kStale };

  Level level = kOk;
  std::string name, message, hardware_id;
  std::vector<std::pair<std::string, std::string>> values;
};

/// diagnostic_msgs/DiagnosticArray.
struct DiagnosticArray {
  Time stamp;
  std::string frame_id;
  std::vector<DiagnosticStatus> status;
};

/// visualization_msgs/Marker without textures and meshes.
struct Marker {
  enum Type : std::int32_t {
    kArrow = 0,
    kCube,
    kSphere,
    kCylinder,
    kLineStrip,
    kLineList,
    kCubeList,
    kSphereList,
    kPoints,
    kText
  };

  enum Action : std::int32_t { kAdd = 0, kDelete = 2, kDeleteAll = 3 };

  Time stamp;
  std::string frame_id, ns;
  std::int32_t id = 0;
  Type type = kLineList;
  Action action = kAdd;
  geometry::SE3 T_frame_marker;
  std::array<double, 3> scale_m = {1.0, 1.0, 1.0};
  std::array<float, 4> rgba = {1.0F, 1.0F, 1.0F, 1.0F};
  Duration lifetime;  ///< 0: until deleted
  std::vector<geometry::Vec3> points_m;
  std::vector<std::array<float, 4>> colors;  ///< empty, or one per point
  std::string text;
};

struct MarkerArray {
  std::vector<Marker> markers;
};

/// One range of a LinkTrack frame.
struct LinktrackNode {
  std::uint8_t role = 0;
  std::uint32_t id = 0;  ///< of the peer; Tagframe0 gives the index in its array
  double range_m = 0.0;
  double fp_rssi_dbm = 0.0, rx_rssi_dbm = 0.0;  ///< 0: not in this frame
};

/// nlink_parser LinktrackNodeframe2, 3, 5 and Tagframe0, in one form. Zero distances mean "none"
/// and are left out.
struct LinktrackFrame {
  Time stamp;  ///< zero for drivers whose messages have no header: use the record time
  std::uint8_t role = 0;
  std::uint32_t id = 0;
  std::uint32_t local_time_ms = 0, system_time_ms = 0;
  std::vector<LinktrackNode> nodes;
  std::uint32_t zeros = 0;  ///< distances that were 0 or not finite
};

/// rali_msgs/Range.
struct RangeMessage {
  Time stamp;
  std::string antenna;  ///< frame_id of the header
  std::string from, to;
  double range_m = 0.0;
  float sigma_m = 0.0F;                               ///< 0 unknown
  float rssi_dbm = 0.0F, rssi_first_path_dbm = 0.0F;  ///< NaN unknown
  std::uint64_t device_time_ns = 0;
  std::uint8_t flags = 0;  ///< 1 line of sight doubtful, 2 smoothed by the device
};

/// A Livox CustomMsg point, for encoding.
struct LivoxPoint {
  std::uint32_t offset_time_ns = 0;
  float x_m = 0.0F, y_m = 0.0F, z_m = 0.0F;
  std::uint8_t reflectivity = 0, tag = 0, line = 0;
};

/// Livox CustomMsg, for encoding; decoding gives a CloudView.
struct LivoxCustom {
  Time stamp;
  std::string frame_id;
  std::uint64_t timebase_ns = 0;
  std::uint8_t lidar_id = 0;
  std::vector<LivoxPoint> points;
};

}  // namespace rali::wire
