// Constraints between the nodes of a path, and the influence of ranges on them.
#include "rali/fleet/centre/joint_graph.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "rali/fleet/centre/inertial_for_test.hpp"

namespace rali::fleet {
namespace {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;

/// A node of a level vehicle at standstill at p_m: its LiDAR constrains all directions, its
/// accelerometer reads 9.81 m/s2.
Increment standing_at(const Vec3& p_m, std::uint32_t k) {
  Increment step;
  step.node = k;
  step.begins = k == 0;
  step.keyframe = k;
  step.levelled = true;
  step.T_odom_body.p = p_m;
  step.lidar_information.setIdentity();
  step.lidar_information *= 1e8;
  if (k > 0) step.inertial = second_at_rest(1e-6);
  return step;
}

/// Sigma along x of the step over the tenth of 20 s, for which the LiDAR has 3 m along x.
double open_step_sigma_m(bool degenerate, const JointSettings& settings) {
  VehiclePath path(VehicleId{0});
  for (std::uint32_t k = 0; k <= 20; ++k) {
    Increment step = standing_at(Vec3::Zero(), k);
    if (k == 10) step.lidar_information(3, 3) = 0.1;
    step.degenerate = degenerate && k == 10;
    path.add(Time::from_s(k), step);
  }
  const std::vector<VehiclePath> paths = {path};
  JointGraph joint(paths, {SE3{}}, settings, {});
  joint.add(JointRanges{}, {});
  joint.solve();
  return std::sqrt(joint.graph().covariance(joint.seq(0, 20))(3, 3));
}

// One or two scans are not marked degenerate before more follow. Such a step was constrained only
// by a sigma of 0.3 m, so ranges shifted all later nodes.
TEST(JointGraph, inertial_factors_constrain_a_step_that_is_degenerate_for_the_lidar) {
  EXPECT_LT(open_step_sigma_m(true, {}), 0.02);
  EXPECT_LT(open_step_sigma_m(false, {}), 0.02);
  JointSettings only_degenerate;
  only_degenerate.shape.loose_m = 10.0;
  EXPECT_GT(open_step_sigma_m(false, only_degenerate), 0.1)
      << "this test needs the step to be open";
}

/// The attitude is known so well that only the accelerometer bends a path.
JointSettings with_rigid_turns() {
  JointSettings settings;
  settings.shape.shape_rad = 1e-6;
  return settings;
}

/// Sigma along a passage that begins at 10 s, 10 s later. @param force_sigma_mps2 as stated at 7 s
double end_of_passage_sigma_m(double force_sigma_mps2) {
  VehiclePath path(VehicleId{0});
  for (std::uint32_t k = 0; k <= 20; ++k) {
    Increment step = standing_at(Vec3::Zero(), k);
    step.degenerate = k >= 10;
    step.force_sigma_mps2 = force_sigma_mps2;
    if (step.degenerate) step.lidar_information(3, 3) = 0.0;
    path.add(Time::from_s(k), step);
  }
  const std::vector<VehiclePath> paths = {path};
  JointGraph joint(paths, {SE3{}}, with_rigid_turns(), {});
  joint.add(JointRanges{}, {});
  joint.solve();
  return std::sqrt(joint.graph().covariance(joint.seq(0, 20))(3, 3));
}

// In a pipe the odometry was right to 0.09 m and the final path, whose three seconds before the
// stretch gave an accelerometer error of 0.014 m/s2, was 0.58 m off.
TEST(JointGraph, a_degenerate_stretch_begins_with_what_the_vehicle_knows_of_its_accelerometer) {
  EXPECT_LT(end_of_passage_sigma_m(1e-4), 0.5 * end_of_passage_sigma_m(0.0));
  EXPECT_NEAR(end_of_passage_sigma_m(0.05), end_of_passage_sigma_m(0.0), 1e-9);
}

// Bias and gravity of an IMU mounted backwards have been added in different frames.
TEST(JointGraph, bias_and_gravity_of_a_turned_imu_are_added_in_its_frame) {
  const double tilt_rad = 0.01;
  VehiclePath path(VehicleId{0});
  for (std::uint32_t k = 0; k <= 20; ++k) {
    Increment step = standing_at(Vec3::Zero(), k);
    step.degenerate = k == 10;
    step.level_sigma_rad = 0.5;
    step.force_sigma_mps2 = 0.001;
    if (k > 0) step.inertial->T_body_imu.R = geometry::so3_exp(Vec3(0.0, 0.0, std::numbers::pi));
    path.add(Time::from_s(k), step);
  }
  const std::vector<VehiclePath> paths = {path};
  JointGraph joint(paths, {SE3{geometry::so3_exp(Vec3(0.0, tilt_rad, 0.0)), Vec3::Zero()}}, {}, {});
  joint.add(JointRanges{}, {});
  joint.solve();
  EXPECT_NEAR(joint.T_map_body(0, 10).R(0, 2), tilt_rad, 1e-3);
}

/// Sigma along a tunnel of the first node with gravity relative to the first node of all, 2 s
/// before.
/// @param stated_m the odometry's sigma of that position
double initialised_sigma_m(double stated_m) {
  VehiclePath path(VehicleId{0});
  for (std::uint32_t k = 0; k <= 10; ++k) {
    Increment step = standing_at(Vec3::Zero(), k);
    step.levelled = k >= 2;
    step.degenerate = step.levelled;
    step.covariance = 1e-6 * geometry::Mat6::Identity();
    if (k < 2) step.inertial.reset();
    if (k > 0) step.lidar_information(3, 3) = 0.0;
    if (k >= 2) step.covariance(3, 3) = stated_m * stated_m;
    path.add(Time::from_s(k), step);
  }
  const std::vector<VehiclePath> paths = {path};
  JointGraph joint(paths, {SE3{}}, {}, {});
  joint.add(JointRanges{}, {});
  joint.solve();
  return std::sqrt(joint.graph().covariance(joint.seq(0, 2))(3, 3));
}

// In a tunnel two vehicles that stood side by side at a known distance were stated 0.27 m along it:
// nothing tied the first node of each to the next.
TEST(JointGraph, the_first_node_is_tied_by_what_the_odometry_states_once_gravity_is_known) {
  EXPECT_NEAR(initialised_sigma_m(0.01), std::hypot(0.01, 0.01), 1e-3);
  EXPECT_GT(initialised_sigma_m(2.0), 0.2) << "a start in motion is as loose as before";
}

/// Degenerate along x for 20 s at 1 m/s, with an accelerometer error of 0.02 m/s2. The filter has
/// not followed it: its sigma is 0.4 m at the end.
VehiclePath degenerate_path() {
  VehiclePath path(VehicleId{0});
  for (std::uint32_t k = 0; k <= 20; ++k) {
    Increment step = standing_at(Vec3(1.0 * k, 0.0, 0.0), k);
    step.v_odom_mps = {1.0, 0.0, 0.0};
    step.degenerate = k > 0;
    if (k > 0) step.lidar_information(3, 3) = 0.0;
    if (k > 0) step.inertial->dv_mps.x() = 0.02;
    if (k > 0) step.inertial->dp_m.x() = 0.01;
    step.covariance.diagonal().tail<3>().setConstant(1e-4);
    step.covariance(3, 3) += 0.008 * k;
    path.add(Time::from_s(k), step);
  }
  return path;
}

// A filter that used a radio at an unknown position was right to 0.2 m. Its final path, from
// inertial data alone, was 10 m off.
TEST(JointGraph, without_ranges_a_degenerate_path_follows_the_filter_estimate) {
  const std::vector<VehiclePath> paths = {degenerate_path()};
  const auto solved = [&](DegenerateSteps steps) {
    JointGraph joint(paths, {SE3{}}, {}, {}, nullptr, steps);
    joint.solve();
    return std::pair(joint.T_map_body(0, 20).p.x(), joint.covariance(0, 20)(3, 3));
  };
  const auto [x_m, variance_m2] = solved(DegenerateSteps::kFilter);
  EXPECT_NEAR(x_m, 20.0, 0.01);
  EXPECT_NEAR(variance_m2, 20 * 0.008, 0.02);
  EXPECT_GT(solved(DegenerateSteps::kInertial).first, 21.0) << "this test needs data that disagree";
}

/// End of a passage of 19 m at 1 m/s from a standing start, with an accelerometer error of
/// 0.02 m/s2. @param at_rest at its last node, 20 s
double end_of_drive_m(bool at_rest) {
  VehiclePath path(VehicleId{0});
  for (std::uint32_t k = 0; k <= 20; ++k) {
    const bool stands = k == 0 || k == 20;
    Increment step = standing_at(Vec3(stands ? 0.95 * k : k - 0.5, 0.0, 0.0), k);
    step.at_rest = k == 0 || (stands && at_rest);
    step.v_odom_mps.x() = stands ? 0.0 : 1.0;
    step.degenerate = k > 0;
    step.force_sigma_mps2 = 0.05;
    if (k > 0) {
      const double dv_mps = 0.02 + (k == 1 ? 1.0 : 0.0) - (k == 20 ? 1.0 : 0.0);
      step.lidar_information(3, 3) = 0.0;
      step.inertial->dv_mps.x() = dv_mps;
      step.inertial->dp_m.x() = 0.5 * dv_mps;
    }
    path.add(Time::from_s(k), step);
  }
  const std::vector<VehiclePath> paths = {path};
  JointGraph joint(paths, {SE3{}}, with_rigid_turns(), {});
  joint.add(JointRanges{}, {});
  joint.solve();
  return joint.T_map_body(0, 20).p.x();
}

// Three vehicles that had just stopped stayed 37 m off: the recording ended before another node
// followed the one at standstill.
TEST(JointGraph, the_last_node_at_standstill_has_no_speed) {
  EXPECT_GT(end_of_drive_m(false), 22.0) << "this test needs an accelerometer with an error";
  EXPECT_NEAR(end_of_drive_m(true), 19.0, 0.1);
}

// A new range after a gap moves the filter along the tunnel. The bend, which rotates the vehicle
// and shifts it across, is uncertain. Treated as motion, both would stay in the path.
TEST(JointGraph, does_not_interpret_a_filter_correction_of_odom_as_motion) {
  VehiclePath path(VehicleId{0});
  const SE3 T_moved_odom{geometry::rotation_from_rpy(0.0, 0.0, 0.1), Vec3(5.0, 0.5, 0.0)};
  for (std::uint32_t k = 0; k <= 20; ++k) {
    const SE3 T = k < 10 ? SE3{} : T_moved_odom;
    const Vec3 axis = T.R.col(0);
    Increment step = standing_at(Vec3::Zero(), k);
    step.T_odom_body = T * SE3{geometry::Mat3::Identity(), Vec3(1.0 * k, 0.0, 0.0)};
    step.v_odom_mps = axis;
    step.degenerate = k > 0;
    if (k > 0) step.lidar_information.bottomRightCorner<3, 3>() -= 1e8 * axis * axis.transpose();
    path.add(Time::from_s(k), step);
  }
  const std::vector<VehiclePath> paths = {path};
  JointGraph joint(paths, {SE3{}}, {}, {});
  joint.solve();
  const SE3 T_end = joint.T_map_body(0, 20);
  EXPECT_LT(geometry::so3_log(T_end.R).norm(), 0.01) << "of 0.1 rad";
  EXPECT_LT(std::abs(T_end.p.y()), 0.1) << "of 1.5 m";
}

enum class End { kOldStructure, kNewStructure, kRanges };

/// The LiDAR does not see the height for 10 s, in which the filter climbs; then it is back at 0.
/// @return height of the path in the middle of that, and 5 s after it
std::pair<double, double> heights_m(End end, double climb_m = 0.5) {
  const double climb_mps = climb_m / 10.0;
  VehiclePath path(VehicleId{0});
  for (std::uint32_t k = 0; k <= 20; ++k) {
    const bool open = k > 5 && k <= 15;
    Increment step = standing_at(Vec3(1.0 * k, 0.0, open ? climb_mps * (k - 5) : 0.0), k);
    step.v_odom_mps = {1.0, 0.0, open ? climb_mps : 0.0};
    if (open || (end == End::kRanges && k == 16)) step.lidar_information(5, 5) = 0.0;
    // An error of the accelerometer that is no constant bias: up, then down.
    if (k > 0) step.inertial = second_at_rest(2.5e-5);
    if (open) step.inertial->dv_mps.z() += (k <= 10 ? 0.4 : -0.4) * climb_mps;
    step.covariance.diagonal().tail<3>().setConstant(1e-6);
    const bool uncertain = open || (end == End::kNewStructure && k > 15);
    if (uncertain) step.covariance(5, 5) = 0.003 * std::min(k - 5, 10U);
    path.add(Time::from_s(k), step);
  }
  const std::vector<VehiclePath> paths = {path};
  JointGraph joint(paths, {SE3{}}, {}, {});
  joint.solve();
  return {joint.T_map_body(0, 12).p.z(), joint.T_map_body(0, 20).p.z()};
}

// A vehicle drifted by 0.25 m of height in a dead end and then saw the floor again. Its final path
// kept the height to its end.
TEST(JointGraph, returns_to_the_map_from_before_a_degenerate_stretch) {
  const auto [within_m, after_m] = heights_m(End::kOldStructure);
  EXPECT_NEAR(after_m, 0.0, 0.02);
  EXPECT_LT(std::abs(within_m), 0.1) << "the stretch distributes the error";
  EXPECT_GT(std::abs(heights_m(End::kNewStructure).second), 0.2)
      << "new structure measures nothing";
  EXPECT_GT(std::abs(heights_m(End::kRanges).second), 0.2) << "ranges have factors of their own";
}

// A correction of less than 0.15 m is taken for motion, and bent the stretch before it by as much.
TEST(JointGraph, distributes_the_error_of_a_degenerate_stretch_also_if_it_is_small) {
  const auto [within_m, after_m] = heights_m(End::kOldStructure, 0.1);
  EXPECT_NEAR(after_m, 0.0, 0.005);
  EXPECT_LT(std::abs(within_m), 0.03);
}

/// Two vehicles stand 3 m apart, known to 0.02 m, and measure ranges 40 times within a minute.
/// @return shift of the second by ranges that are all too long by `excess_m`
/// @param to the excess ends before this range, of 40
double pulled_m(double excess_m, double stretch_sd, int from = 0, int to = 40,
                bool watched = true) {
  std::vector<VehiclePath> paths;
  for (std::uint16_t v = 0; v < 2; ++v) {
    VehiclePath path(VehicleId{v});
    path.add(Time::from_s(0), EpochStart{"v", {Vec3::Zero()}});
    for (std::uint32_t k = 0; k <= 60; ++k) {
      Increment step = standing_at(Vec3::Zero(), k);
      step.at_rest = true;
      path.add(Time::from_s(k), step);
    }
    RangeBlock block;
    for (int k = 0; k < 40; ++k) {
      RangeEntry range;
      range.t = Time::from_s(1.0 + 1.4 * k);
      range.from = VehicleId{0};
      range.to = VehicleId{1};
      range.range_m = 3.0 + (k >= from && k < to ? excess_m : 0.0);
      range.sigma_m = 0.1;
      range.at_rest = true;
      block.ranges.push_back(range);
    }
    path.add(Time::from_s(60), block);
    paths.push_back(std::move(path));
  }
  JointSettings settings;
  settings.bias = false;
  settings.stretch_sd = stretch_sd;
  const SE3 apart{Mat3::Identity(), Vec3(3.0, 0.0, 0.0)};
  ranging::RangingSettings ranging;
  ranging.excess.use = watched;
  JointGraph joint(paths, {SE3{}, apart}, settings, ranging);
  StartPrior start;
  start.path = 1;
  start.T_relative_path = apart;
  start.sigma_m = 0.02;
  joint.add(start);
  joint.add(join_ranges(paths), {});
  joint.solve();
  return joint.T_map_body(1, 60).p.x() - 3.0;
}

// A person between two vehicles at standstill for minutes: each of thousands of ranges had so
// little weight that no gate detected their common error. A map right to 3 mm moved by 3 cm.
TEST(JointGraph, down_weights_ranges_with_a_common_positive_error_together) {
  const double trusting_m = pulled_m(0.3, 0.0);
  EXPECT_GT(trusting_m, 0.02);
  EXPECT_LT(pulled_m(0.3, 2.0), 0.35 * trusting_m);
  EXPECT_GT(pulled_m(0.3, 2.0), 0.0);
  EXPECT_NEAR(pulled_m(0.05, 2.0), pulled_m(0.05, 0.0), 1e-6) << "what noise may do counts whole";
  EXPECT_LT(pulled_m(-0.3, 2.0), -0.4 * trusting_m) << "nothing makes a range too short";
}

// The path was solved with the ranges of an obstacle before they were judged by that path.
TEST(JointGraph, leaves_out_an_obstruction_before_the_first_solution) {
  const double unwatched_m = pulled_m(0.4, 0.0, 25, 36, false);
  EXPECT_GT(unwatched_m, 0.0008);
  EXPECT_LT(std::abs(pulled_m(0.4, 0.0, 25, 36)), 0.3 * unwatched_m);
}

}  // namespace
}  // namespace rali::fleet
