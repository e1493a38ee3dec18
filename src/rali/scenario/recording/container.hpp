#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/scenario/recording/vehicle_recorder.hpp"
#include "rali/wire/encoding.hpp"

namespace rali::scenario {

/// A recording file of any format, as used by VehicleRecorder.
class Container {
 public:
  /// @param path  final name, given to the file by close(); see recording_name()
  [[nodiscard]] static Result<std::unique_ptr<Container>> create(const std::string& path,
                                                                 RecordingFormat format);

  virtual ~Container() = default;

  /// `type` in ROS 1 notation: "sensor_msgs/Imu". Returns the topic argument of write().
  [[nodiscard]] virtual Result<std::size_t> add_topic(const std::string& topic,
                                                      const std::string& type) = 0;
  [[nodiscard]] virtual Status write(std::size_t topic, Time t,
                                     std::span<const std::byte> data) = 0;

  /// From now on only the beginning of the next record is written to the file.
  virtual void cut() = 0;

  [[nodiscard]] virtual Status close() = 0;

  [[nodiscard]] virtual wire::Encoding encoding() const = 0;
};

}  // namespace rali::scenario
