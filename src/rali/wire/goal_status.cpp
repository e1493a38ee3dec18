#include "rali/wire/goal_status.hpp"

#include "rali/wire/byte_reader.hpp"

namespace rali::wire {

Bytes encode(const GoalStatusArray& status) {
  ByteWriter out(Encoding::kCdr);
  out.sequence(status.goals.size());
  for (const GoalStatus& goal : status.goals) {
    for (const std::uint8_t byte : goal.goal_id) out.put(byte);
    out.time(goal.accepted);
    out.put(static_cast<std::int8_t>(goal.state));
  }
  return out.take();
}

Result<GoalStatusArray> decode_goal_status(std::span<const std::byte> message) {
  constexpr std::size_t kGoalBytesMin = 16 + 8 + 1;
  ByteReader in(message, Encoding::kCdr);
  GoalStatusArray status;
  const std::uint32_t goals = in.sequence(kGoalBytesMin);
  for (std::uint32_t i = 0; i < goals && in.ok(); ++i) {
    GoalStatus goal;
    goal.goal_id = in.get_array<std::uint8_t, 16>();
    goal.accepted = in.time();
    const auto state = in.get<std::int8_t>();
    const bool known = state >= GoalStatus::kUnknown && state <= GoalStatus::kAborted;
    goal.state = known ? static_cast<GoalStatus::State>(state) : GoalStatus::kUnknown;
    status.goals.push_back(goal);
  }
  if (!in.ok()) return tl::make_unexpected(in.error("GoalStatusArray"));
  return status;
}

}  // namespace rali::wire
