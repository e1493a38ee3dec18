#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/input/input_report.hpp"
#include "rali/wire/message_kind.hpp"

namespace rali::drive {

/// One topic of a recording, as input of the choice.
struct TopicCount {
  std::string name;
  std::string type;
  wire::MessageKind kind = wire::MessageKind::kOther;
  std::uint64_t messages = 0;
  bool exact = false;  ///< the count is of the whole file, not of the part read so far
};

struct TopicChoice {
  std::string lidar;
  std::string imu;  ///< empty: LiDAR only
};

/// The only cloud topic and the only IMU topic, or those the user named. Two or more of a kind,
/// none, or only raw packets are errors (kInput) that list the available topics with counts.
/// @param file for the error message
[[nodiscard]] Result<TopicChoice> choose_topics(std::span<const TopicCount> topics,
                                                const InputOptions& options,
                                                const std::string& file);

}  // namespace rali::drive
