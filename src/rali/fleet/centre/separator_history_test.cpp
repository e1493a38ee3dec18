#include "rali/fleet/centre/separator_history.hpp"

#include <gtest/gtest.h>

namespace rali::fleet {
namespace {

/// A path of nodes 0 to 20, one a second, each a keyframe.
std::vector<VehiclePath> path() {
  std::vector<VehiclePath> paths;
  paths.emplace_back(VehicleId{3});
  for (std::uint32_t k = 0; k <= 20; ++k) {
    Increment step;
    step.node = k;
    step.keyframe = k;
    step.begins = k == 0;
    step.T_odom_body.p.x() = k;
    paths[0].add(Time::from_s(k), step);
  }
  return paths;
}

SeparatorPrior separator_at(std::uint32_t node) {
  SeparatorPrior out;
  out.until = Time::from_s(node);
  SeparatorPath end;
  end.stream = {VehicleId{3}, 0};
  end.node = node;
  end.T_map_body.p.x() = node;
  out.paths.push_back(end);
  return out;
}

SeparatorHistory at(std::initializer_list<std::uint32_t> nodes, std::size_t maximum = 100) {
  SeparatorHistory history(maximum);
  for (const std::uint32_t node : nodes) history.push(separator_at(node));
  return history;
}

TEST(SeparatorHistory, returns_the_newest_separator_before_the_node_and_drops_later_ones) {
  const auto paths = path();
  SeparatorHistory history = at({4, 8, 12});
  const std::vector<std::size_t> node{9};
  std::vector<Time> ends{Time::from_s(20.0)};
  EXPECT_EQ(history.take(paths, node, 1, ends)->paths[0].node, 8U);
  EXPECT_EQ(history.size(), 1U) << "of those that the loop lies over none is kept";
  const std::vector<Time> again{Time::from_s(12.0), Time::from_s(20.0)};
  EXPECT_EQ(ends, again) << "but made again";
  EXPECT_EQ(history.take(paths, node, 1, ends)->paths[0].node, 4U);
  EXPECT_EQ(ends, again);
  EXPECT_FALSE(history.take(paths, node, 1, ends));
}

TEST(SeparatorHistory, goes_back_at_least_the_requested_number_of_separators) {
  const auto paths = path();
  SeparatorHistory history = at({4, 8, 12});
  const std::vector<std::size_t> node{20};
  std::vector<Time> ends;
  EXPECT_EQ(history.take(paths, node, 2, ends)->paths[0].node, 8U);
  EXPECT_FALSE(history.take(paths, node, 2, ends)) << "one is left";
  EXPECT_EQ(history.size(), 0U);
}

TEST(SeparatorHistory, counts_a_node_on_the_separator_as_after_it) {
  const auto paths = path();
  SeparatorHistory history = at({4, 8});
  const std::vector<std::size_t> node{8};
  std::vector<Time> ends;
  EXPECT_EQ(history.take(paths, node, 1, ends)->paths[0].node, 8U);
}

TEST(SeparatorHistory, reports_the_first_node_of_the_last_n_rounds) {
  const auto paths = path();
  EXPECT_EQ(at({4, 8, 12}).begins(paths, 2), std::vector<std::size_t>{8});
  EXPECT_EQ(at({4, 8, 12}).begins(paths, 9), std::vector<std::size_t>{4});
  EXPECT_TRUE(at({4, 8, 12}).begins(paths, 0).empty());
  EXPECT_TRUE(at({}).begins(paths, 3).empty());
}

TEST(SeparatorHistory, drops_the_oldest_beyond_its_maximum) {
  SeparatorHistory history = at({2, 4, 6, 8}, 2);
  EXPECT_EQ(history.size(), 2U);
  const auto paths = path();
  std::vector<Time> ends;
  EXPECT_EQ(history.take(paths, std::vector<std::size_t>{20}, 2, ends)->paths[0].node, 6U);
  EXPECT_EQ(at({2, 4}, 0).size(), 0U);
}

TEST(SeparatorHistory, keeps_only_separators_whose_keyframes_moved_less_than_the_tolerance) {
  const auto paths = path();
  FleetEstimate reported;
  for (std::uint32_t k = 0; k <= 20; ++k) {
    geometry::SE3 T;
    T.p.x() = k < 10 ? k : k + 0.05;
    reported.keyframes[{VehicleId{3}, k}].T_map_body = T;
  }
  SeparatorHistory history = at({4, 8, 12, 16});
  history.keep_true(paths, reported, Time::from_s(20.0), 0.01);
  EXPECT_EQ(history.size(), 2U) << "nodes 12 and 16 were moved by 5 cm";
  history.keep_true(paths, reported, Time::from_s(8.0), 0.01);
  EXPECT_EQ(history.size(), 1U) << "not before that time";
  history.keep_true(paths, {}, Time::from_s(8.0), 0.01);
  EXPECT_EQ(history.size(), 0U) << "nobody told where they are";
}

}  // namespace
}  // namespace rali::fleet
