#include "rali/host/goal_watch.hpp"

#include <gtest/gtest.h>

namespace rali::host {
namespace {

wire::GoalStatusArray goal(std::uint8_t id, double accepted_s, wire::GoalStatus::State state) {
  wire::GoalStatusArray array;
  array.goals.resize(1);
  array.goals[0].goal_id[0] = id;
  array.goals[0].accepted = Time::from_s(accepted_s);
  array.goals[0].state = state;
  return array;
}

TEST(GoalWatch, has_no_state_without_a_navigation_report) {
  GoalWatch watch;
  watch.sent(1);
  EXPECT_FALSE(watch.state());
}

TEST(GoalWatch, ignores_a_goal_received_before_the_own_order) {
  GoalWatch watch;
  watch.received(goal(1, 10.0, wire::GoalStatus::kSucceeded));
  watch.sent(1);
  EXPECT_FALSE(watch.state());
  watch.received(goal(1, 10.0, wire::GoalStatus::kSucceeded));
  EXPECT_FALSE(watch.state());
  watch.received(goal(2, 11.0, wire::GoalStatus::kExecuting));
  EXPECT_EQ(watch.state(), fleet::DriveState::kDriving);
  watch.received(goal(2, 11.0, wire::GoalStatus::kSucceeded));
  EXPECT_EQ(watch.state(), fleet::DriveState::kArrived);
}

TEST(GoalWatch, a_new_order_has_no_state_until_its_goal_is_reported) {
  GoalWatch watch;
  watch.sent(1);
  watch.received(goal(1, 10.0, wire::GoalStatus::kSucceeded));
  watch.sent(2);
  EXPECT_FALSE(watch.state());
  watch.received(goal(2, 12.0, wire::GoalStatus::kAborted));
  EXPECT_EQ(watch.state(), fleet::DriveState::kGivenUp);
  watch.sent(2);
  EXPECT_EQ(watch.state(), fleet::DriveState::kGivenUp) << "the same order again";
}

TEST(GoalWatch, uses_the_newest_of_several_goals) {
  GoalWatch watch;
  watch.sent(1);
  wire::GoalStatusArray both = goal(2, 20.0, wire::GoalStatus::kExecuting);
  both.goals.push_back(goal(1, 10.0, wire::GoalStatus::kAborted).goals[0]);
  watch.received(both);
  EXPECT_EQ(watch.state(), fleet::DriveState::kDriving);
}

}  // namespace
}  // namespace rali::host
