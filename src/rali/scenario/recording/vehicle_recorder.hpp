#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "rali/base/result.hpp"
#include "rali/base/settings.hpp"
#include "rali/base/time.hpp"
#include "rali/sensor/imu_sample.hpp"
#include "rali/sensor/lidar_scan.hpp"
#include "rali/sim/lidar_model.hpp"
#include "rali/wire/cloud_pack.hpp"

namespace rali::scenario {

enum class RecordingFormat { kMcap, kBag, kRosbag2 };
inline constexpr ChoiceNames<3> kRecordingFormatNames{"mcap", "bag", "rosbag2"};

/// Message conventions of a LiDAR's driver.
struct LidarDriver {
  std::string_view topic;
  std::string_view frame;
  std::string_view model;  ///< as in fleet.yaml
  wire::CloudStyle style = wire::CloudStyle::kXyzi;
};

/// The driver most likely used with this LiDAR.
[[nodiscard]] LidarDriver driver_of(sim::Lidar lidar);

inline constexpr std::string_view kImuTopic = "/imu/data";

/// Name of a recording: `v1.mcap`, `v1.bag`, or the folder `v1`.
[[nodiscard]] std::string recording_name(const std::string& vehicle, RecordingFormat format);

/// Writes the recording of one vehicle: an MCAP of profile ros2, a ROS 1 bag, or a rosbag2 folder,
/// with the LiDAR's and the IMU's topic. close() gives it its final name. Memory does not grow with
/// its length.
class VehicleRecorder {
 public:
  struct Options {
    std::string folder;   ///< must exist
    std::string vehicle;  ///< "v1"
    RecordingFormat format = RecordingFormat::kMcap;
    sim::Lidar lidar = sim::Lidar::kRs16;
    /// The file is truncated here, in the middle of a record, as if the disk had been removed.
    std::optional<Time> cut_at;
  };

  /// Errors: kMachine.
  [[nodiscard]] static Result<std::unique_ptr<VehicleRecorder>> create(const Options& options);

  virtual ~VehicleRecorder() = default;

  /// @param t_record  time of receipt at the recorder; the stamp is the message's own
  [[nodiscard]] virtual Status add(const sensor::ImuSample& sample, Time t_record) = 0;

  /// A scan without point times gets a time field of zeros.
  [[nodiscard]] virtual Status add(const sensor::LidarScan& scan, Time t_record) = 0;

  [[nodiscard]] virtual Status close() = 0;
};

}  // namespace rali::scenario
