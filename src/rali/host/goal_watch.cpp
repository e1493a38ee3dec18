#include "rali/host/goal_watch.hpp"

namespace rali::host {

void GoalWatch::sent(std::uint64_t number) {
  if (number_ == number) return;
  number_ = number;
  before_.reset();
  if (newest_) before_ = newest_->goal_id;
}

void GoalWatch::received(const wire::GoalStatusArray& status) {
  for (const wire::GoalStatus& goal : status.goals) {
    const bool newer = !newest_ || goal.accepted >= newest_->accepted;
    if (newer || goal.goal_id == newest_->goal_id) newest_ = goal;
  }
}

std::optional<fleet::DriveState> GoalWatch::state() const {
  if (!number_ || !newest_ || before_ == newest_->goal_id) return std::nullopt;
  switch (newest_->state) {
    case wire::GoalStatus::kAccepted:
    case wire::GoalStatus::kExecuting:
    case wire::GoalStatus::kCanceling:
      return fleet::DriveState::kDriving;
    case wire::GoalStatus::kSucceeded:
      return fleet::DriveState::kArrived;
    case wire::GoalStatus::kAborted:
      return fleet::DriveState::kGivenUp;
    case wire::GoalStatus::kCanceled:
    case wire::GoalStatus::kUnknown:
      break;
  }
  return std::nullopt;
}

}  // namespace rali::host
