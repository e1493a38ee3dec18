#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/settings.hpp"
#include "rali/config/extrinsics.hpp"
#include "rali/config/field.hpp"
#include "rali/config/room_settings.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/wire/cloud_format.hpp"

namespace rali::config {

enum class Returns { kAuto, kSingle, kStrongest, kLast };
inline constexpr ChoiceNames<4> kReturnsNames{"auto", "single", "strongest", "last"};

struct LidarConfig {
  std::string topic = "auto";      ///< auto: the only cloud topic
  wire::CloudFormatOptions cloud;  ///< its keys are siblings of `topic`
  Returns returns = Returns::kAuto;
  Extrinsics T_body_lidar;
  std::optional<double> time_offset_s;  ///< added to LiDAR stamps; empty = auto
};

enum class AccelUnit { kAuto, kMps2, kG };
inline constexpr ChoiceNames<3> kAccelUnitNames{"auto", "m_s2", "g"};
enum class GyroUnit { kAuto, kRadps, kDegps };
inline constexpr ChoiceNames<3> kGyroUnitNames{"auto", "rad_s", "deg_s"};

/// Noise values that override the table of IMU models; empty = from the table.
struct ImuNoiseConfig {
  std::optional<double> accel_mps2_rthz, gyro_radps_rthz, accel_walk_mps3_rthz,
      gyro_walk_radps2_rthz;
};

struct ImuConfig {
  std::string topic = "auto";  ///< auto: the only one; none: LiDAR alone
  std::string file;            ///< a CSV of inertial data instead of a topic; empty = none
  std::string model = "generic_mems";
  AccelUnit accel_unit = AccelUnit::kAuto;
  GyroUnit gyro_unit = GyroUnit::kAuto;
  ImuNoiseConfig noise;
  std::optional<double> vibration_factor;                            ///< empty = auto
  Extrinsics T_body_imu = {Extrinsics::Source::kGiven, {}, {}, {}};  ///< body = IMU unless given
};

struct AntennaConfig {
  std::string name;
  geometry::Vec3 p_body_m = geometry::Vec3::Zero();
};

/// What `rali run` needs about one vehicle besides its sensors.
struct VehicleLiveConfig {
  std::string address;      ///< on the network of the fleet; empty = not given
  std::string serial_port;  ///< of a LinkTrack radio; empty = none
  int serial_baud = 921600;
};

/// One vehicle: its recording and its sensors.
struct VehicleConfig {
  std::string name = "v1";
  std::vector<std::string> recordings;   ///< paths as this process can open them, read in order
  double start_s = 0.0;                  ///< seconds of data left out at the beginning
  double duration_s = 0.0;               ///< seconds of data used, 0 = all
  std::optional<double> clock_offset_s;  ///< added to all stamps; empty = auto
  LidarConfig lidar;
  ImuConfig imu;
  std::vector<AntennaConfig> antennas = {{"uwb", geometry::Vec3::Zero()}};
  /// xmin,xmax,ymin,ymax,zmin,zmax in body [m]: the vehicle's own structure; points in it are left
  /// out.
  std::optional<std::array<double, 6>> self_box_m;
  VehicleLiveConfig live;
};

/// The owner of a radio number: a vehicle and one of its antennas (empty = the first).
struct RadioName {
  std::string vehicle, antenna;
};

struct RangeSource {
  std::string file, topic, serial_log;  ///< exactly one is set
  /// Of a serial log or file: the vehicle whose computer recorded it. Of a file it may be empty:
  /// the first.
  std::string vehicle;
  std::map<std::int64_t, RadioName> ids;
};

enum class StampSource { kAuto, kDevice, kRecord };
inline constexpr ChoiceNames<3> kStampSourceNames{"auto", "device", "record"};

struct RangesConfig {
  std::vector<RangeSource> sources;
  StampSource stamp = StampSource::kAuto;
  std::optional<double> latency_s;  ///< empty = auto
  double sigma_m = 0.10;
  /// bias_m: neither set = estimate.
  std::optional<double> bias_m;
  std::map<std::string, double> pair_bias_m;  ///< "v1-v2" -> m
  std::array<double, 2> limits_m = {0.2, 200.0};
};

enum class Clock { kSynchronised, kOffset, kSeparate };
inline constexpr ChoiceNames<3> kClockNames{"synchronised", "offset", "separate"};

/// A known start pose of one vehicle in another one's first pose.
struct PriorConfig {
  std::string vehicle, relative_to;
  geometry::Vec3 p_m = geometry::Vec3::Zero();
  double yaw_deg = 0.0;
  double sigma_m = 0.2, sigma_deg = 3.0;
};

enum class OutputFrame { kBody, kLidar, kImu };
inline constexpr ChoiceNames<3> kOutputFrameNames{"body", "lidar", "imu"};

struct OutputConfig {
  OutputFrame frame = OutputFrame::kBody;
  std::string georeference;  ///< CSV of marks; empty = none
};

/// The networks of `rali run`, the same for all vehicles.
struct LiveConfig {
  int ros_domain = 0;                ///< ROS_DOMAIN_ID of the vehicle's own network
  std::string ros_interface = "lo";  ///< name or address
  int fleet_domain = 77;
  std::string key_file;  ///< of the fleet; empty = none
  std::string view_bind = "127.0.0.1";
  int view_port = 8765;
  std::string view_token_file;  ///< needed if view_bind is not loopback; empty = none
};

/// fleet.yaml with defaults filled in.
struct FleetConfig {
  int schema = 1;
  std::string preset = "robust";
  std::vector<VehicleConfig> vehicles;
  RangesConfig ranges;
  std::string radio_file;  ///< empty = none
  Clock clock = Clock::kSynchronised;
  std::vector<PriorConfig> priors;
  std::string rounds = "auto";  ///< auto, off, or a CSV file
  OutputConfig output;
  LiveConfig live;
  RoomSettings settings;
  Origins origins;                   ///< of every value that is not a default
  std::vector<std::string> notices;  ///< sentences about keys with old names
};

/// Every field of fleet.yaml as a flat list that points into `config`. Paths are encoded
/// relative to `base_dir` and decoded against it; "" leaves them unchanged.
[[nodiscard]] FieldList fleet_fields(FleetConfig& config, const std::string& base_dir);

}  // namespace rali::config
