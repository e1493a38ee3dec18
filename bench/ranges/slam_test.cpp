#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "rali/geometry/so3.hpp"
#include "slam_table.hpp"

namespace rali::ranges_bench {
namespace {

using geometry::Vec3;

/// 12 poses on a curved path, steps with the given error, exact ranges to L0 at (3, 8) and to the
/// stationary robots B at (-4, 2) and C at (9, 1).
Pyfg bent_path(double step_error_m) {
  std::string text;
  double x = 0.0, y = 0.0, yaw = 0.0;
  for (int k = 0; k < 12; ++k) {
    text += fmt::format("VERTEX_SE2 {0} A{0} {1} {2} {3}\n", k, x, y, yaw);
    x += std::cos(yaw);
    y += std::sin(yaw);
    yaw += 0.2;
  }
  text += "VERTEX_SE2 0 B0 -4 2 0\nVERTEX_SE2 0 C0 9 1 0\nVERTEX_XY L0 3 8\n";
  x = y = yaw = 0.0;
  for (int k = 0; k < 12; ++k) {
    if (k > 0) {
      text += fmt::format("EDGE_SE2 {} A{} A{} {} 0 0.2 0.01 0 0 0.01 0 0.0001\n", k, k - 1, k,
                          1.0 + step_error_m);
    }
    text += fmt::format("EDGE_RANGE {} A{} L0 {} 0.0001\n", k, k, std::hypot(x - 3.0, y - 8.0));
    text += fmt::format("EDGE_RANGE {} B0 A{} {} 0.0001\n", k, k, std::hypot(x + 4.0, y - 2.0));
    text += fmt::format("EDGE_RANGE {} A{} C0 {} 0.0001\n", k, k, std::hypot(x - 9.0, y - 1.0));
    x += std::cos(yaw);
    y += std::sin(yaw);
    yaw += 0.2;
  }
  return *parse_pyfg(text, "bent");
}

/// The same with a rotation error of 0.02 rad per step and range errors of half a metre.
SlamProblem bent_noisy(SlamProblem problem) {
  for (graph::RelativePoseFactor& step : problem.steps) {
    step.T_i_j.R = step.T_i_j.R * geometry::rotation_from_rpy(0.0, 0.0, 0.02);
  }
  for (TrackRange& range : problem.ranges) range.range_m += 0.5;
  return problem;
}

TEST(SlamProblem, takes_the_ranges_of_one_robot_and_one_kind) {
  const Pyfg file = bent_path(0.0);
  EXPECT_EQ(robots_of(file), (std::vector<char>{'A', 'B', 'C'}));
  const auto beacons = problem_of(file, "p", 'A', Ends::kBeacons);
  ASSERT_TRUE(beacons);
  EXPECT_EQ(beacons->ranges.size(), 12u);
  EXPECT_EQ(beacons->beacons_m.at(0), Vec3(3.0, 8.0, 0.0));
  const auto standing = problem_of(file, "p", 'A', Ends::kStanding);
  ASSERT_TRUE(standing);
  EXPECT_EQ(standing->beacons_m.at(1001), Vec3(-4.0, 2.0, 0.0));
  const auto known = problem_of(file, "p", 'A', Ends::kKnownRobots);
  ASSERT_TRUE(known);
  EXPECT_TRUE(known->known_points());
  EXPECT_EQ(known->ranges.size(), 24u);
  EXPECT_EQ(known->ranges.at(2).p_known_m, Vec3(-4.0, 2.0, 0.0));
  EXPECT_FALSE(problem_of(file, "p", 'B', Ends::kKnownRobots));  // is stationary itself
  EXPECT_FALSE(problem_of(file, "p", 'D', Ends::kBeacons));
}

TEST(SlamProblem, odometry_with_a_gap_is_refused) {
  Pyfg file = bent_path(0.0);
  file.steps.erase(file.steps.begin() + 4);
  const auto problem = problem_of(file, "p", 'A', Ends::kBeacons);
  ASSERT_FALSE(problem);
  EXPECT_NE(problem.error().message().find("after pose 4"), std::string::npos);
}

TEST(SlamRun, exact_steps_and_ranges_give_the_true_way_and_beacon) {
  const auto scores = run_problem(*problem_of(bent_path(0.0), "p", 'A', Ends::kBeacons));
  ASSERT_TRUE(scores);
  EXPECT_LT(scores->ape_odometry_m, 1e-9);
  EXPECT_LT(scores->ape_batch_m, 1e-3);
  EXPECT_LT(scores->beacons_off_m, 0.01);
  EXPECT_LT(scores->cost, 1e-3);
}

// Steps are 10 % too long: two known points determine the scale error and the pose of odom.
TEST(SlamRun, ranges_to_a_known_point_take_back_what_odometry_did_wrong) {
  const auto problem = *problem_of(bent_path(0.1), "p", 'A', Ends::kKnownRobots);
  const auto scores = run_problem(problem);
  ASSERT_TRUE(scores);
  EXPECT_GT(scores->ape_odometry_m, 0.1);
  EXPECT_LT(scores->ape_batch_m, 0.5 * scores->ape_odometry_m);
}

TEST(SlamPlacing, the_frame_is_found_without_knowing_anything_of_it) {
  auto problem = *problem_of(bent_path(0.0), "p", 'A', Ends::kKnownRobots);
  const geometry::SE3 turn{geometry::rotation_from_rpy(0.0, 0.0, 2.0), Vec3(5.0, -7.0, 0.0)};
  for (TrackRange& range : problem.ranges) range.p_known_m = turn * range.p_known_m;
  const geometry::SE3 found = place_frame(problem, odometry_alone(problem), 100);
  EXPECT_LT((found.p - turn.p).norm(), 1e-3);
  EXPECT_LT((found.R - turn.R).norm(), 1e-3);
}

// Basis of the measured sigmas: every step is 0.1 m too long with a stated sigma of 0.1 m.
TEST(SlamProblem, measured_sigmas_are_those_of_the_errors) {
  const auto problem = *problem_of(bent_path(0.1), "p", 'A', Ends::kBeacons);
  EXPECT_NEAR(steps_nees(problem), 1.0 / 3.0, 1e-9);
  const SlamProblem measured = with_measured_sigmas(bent_noisy(problem));
  EXPECT_NEAR(steps_nees(measured), 1.0, 1e-9);
  EXPECT_NEAR(measured.ranges.front().sigma_m, 0.5, 1e-9);
}

std::filesystem::path data_folder() {
  const char* from_user = std::getenv("RALI_DATA_DIR");
  return std::filesystem::path(from_user != nullptr ? from_user : RALI_DATA_DIR) / "range_slam";
}

TEST(SlamRun, the_small_exact_file_comes_out_exactly) {
  const auto path = data_folder() / "factor_graph_small.pyfg";
  if (!std::filesystem::exists(path)) {
    GTEST_SKIP() << "NO DATA, EXACT FILE NOT SOLVED: " << path << "; set RALI_DATA_DIR";
  }
  const auto file = read_pyfg(path);
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->poses.size(), 6u);
  const auto problem = problem_of(*file, "small", 'A', Ends::kBeacons);
  ASSERT_TRUE(problem);
  const auto scores = run_problem(*problem);
  ASSERT_TRUE(scores) << scores.error().message();
  EXPECT_LT(scores->range_rms_m, 1e-8);
  EXPECT_LT(scores->ape_odometry_m, 1e-6);
  EXPECT_LT(scores->ape_batch_m, 1e-3);
  EXPECT_LT(scores->beacons_off_m, 0.05);
}

}  // namespace
}  // namespace rali::ranges_bench
