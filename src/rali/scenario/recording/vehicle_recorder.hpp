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

/// How the driver of a LiDAR sends its sweeps.
struct LidarDriver {
  std::string_view topic;
  std::string_view frame;
  std::string_view model;  ///< as in fleet.yaml
  wire::CloudStyle style = wire::CloudStyle::kXyzi;
};

/// The driver that a user of this LiDAR most probably has.
[[nodiscard]] LidarDriver driver_of(sim::Lidar lidar);

inline constexpr std::string_view kImuTopic = "/imu/data";

/// What a recording is called: `v1.mcap`, `v1.bag`, or the folder `v1`.
[[nodiscard]] std::string recording_name(const std::string& vehicle, RecordingFormat format);

/// Writes the recording of one vehicle: an MCAP of profile ros2, a ROS 1 bag, or a rosbag2 folder,
/// with the LiDAR's and the IMU's topic. It appears under its name at close(). Memory does not
/// grow with it.
class VehicleRecorder {
 public:
  struct Options {
    std::string folder;   ///< exists
    std::string vehicle;  ///< "v1"
    RecordingFormat format = RecordingFormat::kMcap;
    sim::Lidar lidar = sim::Lidar::kRs16;
    /// The file breaks off here, in the middle of a record, as if the disk had been pulled.
    std::optional<Time> cut_at;
  };

  /// Errors: kMachine.
  [[nodiscard]] static Result<std::unique_ptr<VehicleRecorder>> create(const Options& options);

  virtual ~VehicleRecorder() = default;

  /// @param t_record  when the recorder gets it; the stamp is the message's own
  [[nodiscard]] virtual Status add(const sensor::ImuSample& sample, Time t_record) = 0;

  /// A sweep without point times has a time field of zeros.
  [[nodiscard]] virtual Status add(const sensor::LidarScan& scan, Time t_record) = 0;

  [[nodiscard]] virtual Status close() = 0;
};

}  // namespace rali::scenario
