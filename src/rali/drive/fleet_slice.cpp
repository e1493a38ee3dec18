#include "rali/drive/fleet_slice.hpp"

#include <algorithm>
#include <variant>

namespace rali::drive {
namespace {

bool has_lost_pose(const vehicle::OutputList& outputs) {
  return std::any_of(outputs.begin(), outputs.end(), [](const vehicle::Output& output) {
    const auto* pose = std::get_if<vehicle::PoseEstimate>(&output);
    return pose != nullptr && pose->quality == vehicle::PoseQuality::kDiverged;
  });
}

/// Runs the events of one vehicle among those of all.
void run_one(const FleetMember& member, std::size_t vehicle, bool strict, Executor& executor,
             std::vector<SliceStep>& steps) {
  for (SliceStep& step : steps) {
    if (step.vehicle != vehicle) continue;
    member.step(step.event, executor, step.outputs);
    step.done = true;
    step.last = std::holds_alternative<vehicle::EndOfData>(step.event);
    if (strict && !step.last && has_lost_pose(step.outputs)) {
      member.step(vehicle::EndOfData{}, executor, step.outputs);
      step.last = true;
    }
    if (step.last) return;
  }
}

}  // namespace

void run_slice(std::span<const FleetMember> members, const std::vector<bool>& ended, bool strict,
               Executor& executor, std::vector<SliceStep>& steps) {
  executor.for_blocks(members.size(), 1, [&](std::size_t vehicle, std::size_t, std::size_t) {
    if (!ended[vehicle]) run_one(members[vehicle], vehicle, strict, executor, steps);
  });
}

}  // namespace rali::drive
