#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/wire/byte_writer.hpp"

/// Result of goals as a navigation stack publishes it: the topic `navigate_to_pose/_action/status`
/// of Nav2. Its bt_navigator takes each PoseStamped on `goal_pose` as a goal of that action.
namespace rali::wire {

/// action_msgs/GoalStatus.
struct GoalStatus {
  enum State : std::int8_t {
    kUnknown = 0,
    kAccepted,
    kExecuting,
    kCanceling,
    kSucceeded,
    kCanceled,
    kAborted
  };

  std::array<std::uint8_t, 16> goal_id{};
  Time accepted;
  State state = kUnknown;
};

/// action_msgs/GoalStatusArray.
struct GoalStatusArray {
  std::vector<GoalStatus> goals;
};

inline constexpr std::string_view kGoalStatusType = "action_msgs/msg/GoalStatusArray";

/// In CDR; only ROS 2 has this message.
[[nodiscard]] Bytes encode(const GoalStatusArray& status);

/// States that action_msgs does not define become kUnknown. Errors: kInput, truncated bytes.
[[nodiscard]] Result<GoalStatusArray> decode_goal_status(std::span<const std::byte> message);

}  // namespace rali::wire
