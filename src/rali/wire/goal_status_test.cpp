#include "rali/wire/goal_status.hpp"

#include <gtest/gtest.h>

namespace rali::wire {
namespace {

GoalStatusArray two_goals() {
  GoalStatusArray status;
  status.goals.resize(2);
  status.goals[0].goal_id[0] = 7;
  status.goals[0].accepted = Time::from_ns(3'000'000'005);
  status.goals[0].state = GoalStatus::kAborted;
  status.goals[1].goal_id[15] = 9;
  status.goals[1].accepted = Time::from_ns(4'000'000'000);
  status.goals[1].state = GoalStatus::kExecuting;
  return status;
}

TEST(GoalStatus, has_the_byte_layout_of_the_message_definition) {
  GoalStatusArray one;
  one.goals.resize(1);
  one.goals[0].goal_id = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
  one.goals[0].accepted = Time::from_ns(2'000'000'003);
  one.goals[0].state = GoalStatus::kSucceeded;
  const Bytes bytes = encode(one);
  const std::vector<int> expected{0,  1,  0, 0,                                     // encapsulation
                                  1,  0,  0, 0,                                     // one goal
                                  1,  2,  3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14,  // id
                                  15, 16,                                           //
                                  2,  0,  0, 0, 3, 0, 0, 0,                         // stamp
                                  4};                                               // succeeded
  ASSERT_EQ(bytes.size(), expected.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    EXPECT_EQ(std::to_integer<int>(bytes[i]), expected[i]) << "byte " << i;
  }
}

TEST(GoalStatus, survives_a_round_trip) {
  const GoalStatusArray status = two_goals();
  const auto read = decode_goal_status(encode(status));
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->goals.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read->goals[i].goal_id, status.goals[i].goal_id);
    EXPECT_EQ(read->goals[i].accepted, status.goals[i].accepted);
    EXPECT_EQ(read->goals[i].state, status.goals[i].state);
  }
}

TEST(GoalStatus, truncated_at_any_byte_is_refused) {
  const Bytes whole = encode(two_goals());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(decode_goal_status(std::span(whole).first(size))) << size << " bytes";
  }
}

TEST(GoalStatus, undefined_state_values_are_decoded_as_unknown) {
  Bytes bytes = encode(two_goals());
  bytes.back() = std::byte{42};
  const auto read = decode_goal_status(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->goals[1].state, GoalStatus::kUnknown);
}

}  // namespace
}  // namespace rali::wire
