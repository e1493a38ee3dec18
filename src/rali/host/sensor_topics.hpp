#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/drive/input/input_report.hpp"
#include "rali/drive/input/topic_choice.hpp"
#include "rali/net/ros_bus.hpp"

namespace rali::host {

/// The topics that a vehicle subscribes to, as published.
struct SensorTopics {
  net::RosTopic lidar;
  std::optional<net::RosTopic> imu;       ///< none: imu.topic is none
  std::vector<net::RosTopic> transforms;  ///< /tf_static
};

/// Chooses by name or by type, as `rali map` does in a recording: two clouds or two IMUs are an
/// error. In contrast to a recording, an IMU is required unless the settings say none: its driver
/// may only start late.
/// @param fleet names of all vehicles: topics that rali itself publishes are no sensors, and
/// /OTHER/... belongs to that vehicle
/// Errors (kInput): a sentence that states what is waited for.
[[nodiscard]] Result<SensorTopics> choose_sensors(std::span<const net::RosTopic> published,
                                                  const drive::InputOptions& options,
                                                  std::span<const std::string> fleet);

/// Topics that carry ranges, except those that rali itself publishes and those of other vehicles:
/// the ones that `ranges` names, or all if it names none.
[[nodiscard]] std::vector<net::RosTopic> range_topics(std::span<const net::RosTopic> published,
                                                      const drive::RangeOptions& ranges,
                                                      const std::string& vehicle,
                                                      std::span<const std::string> fleet);

}  // namespace rali::host
