// Gravity constraint of a path: one error for all of it, however long it is.
#include <cmath>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>

#include "rali/fleet/centre/inertial_for_test.hpp"
#include "rali/fleet/centre/joint_graph.hpp"
#include "rali/fleet/centre/path_frames.hpp"

namespace rali::fleet {
namespace {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;

constexpr double kDegree = std::numbers::pi / 180.0;

/// A metre per node straight ahead, all known except the pose of the whole path. Every other 20
/// metres may be degenerate.
VehiclePath path(std::uint16_t vehicle, std::uint32_t nodes, bool levelled = true,
                 bool with_degenerate = false) {
  VehiclePath p(VehicleId{vehicle});
  for (std::uint32_t k = 0; k < nodes; ++k) {
    Increment step;
    step.node = k;
    step.begins = k == 0;
    step.keyframe = k;
    step.levelled = levelled;
    step.T_odom_body.p = {1.0 * k, 0.0, 0.0};
    step.lidar_information.setIdentity();
    step.lidar_information *= 1e8;
    step.v_odom_mps = {1.0, 0.0, 0.0};
    step.degenerate = with_degenerate && k / 20 % 2 == 1;
    if (with_degenerate && k > 0) step.inertial = second_at_rest(1e-4);
    p.add(Time::from_s(k), step);
  }
  return p;
}

/// Sigma of the pitch of the second path's first node, its frame given by a start pose.
double pitch_sigma_deg(const VehiclePath& second) {
  const std::vector<VehiclePath> paths = {
      path(0, static_cast<std::uint32_t>(second.nodes().size())), second};
  JointGraph joint(paths, {SE3{}, SE3{}}, {}, {});
  StartPrior start;
  start.path = 1;
  joint.add(start);
  joint.add(JointRanges{}, {});
  joint.solve();
  return std::sqrt(joint.graph().covariance(joint.seq(1, 0))(1, 1)) / kDegree;
}

double pitch_sigma_deg(std::uint32_t nodes, bool levelled, bool with_degenerate = false) {
  return pitch_sigma_deg(path(1, nodes, levelled, with_degenerate));
}

// Thirty factors treated as independent gave a sigma of 0.05 deg, and kept a frame 4 sigma away
// from its true pose.
TEST(JointTilt, pitch_sigma_stays_above_0_3_deg_however_long_the_path) {
  EXPECT_NEAR(pitch_sigma_deg(10, true), 0.3 * std::sqrt(2.0), 0.01);        // 1/2
  EXPECT_NEAR(pitch_sigma_deg(30, true), 0.3 * std::sqrt(3.0 / 2.0), 0.01);  // 1/2 + 1/6
  EXPECT_NEAR(pitch_sigma_deg(600, true), 0.3 * std::sqrt(31.0 / 30.0), 0.02);
}

// The accelerometer of a degenerate stretch measures gravity with the bias that has tilted the
// odometry already. As an independent measurement it bent a pipe by 0.2 deg in 70 m.
TEST(JointTilt, degenerate_stretches_do_not_measure_the_level_again) {
  EXPECT_NEAR(pitch_sigma_deg(200, true, true), pitch_sigma_deg(200, true), 0.02);
}

TEST(JointTilt, degenerate_stretches_without_a_known_gravity_leave_finite_poses) {
  const VehiclePath driven = path(0, 60, true, true);
  VehiclePath p(VehicleId{0});
  for (const VehiclePath::Node& node : driven.nodes()) {
    Increment step = *node.step;
    step.g_odom_mps2.setZero();
    p.add(node.t, step);
  }
  const std::vector<VehiclePath> paths = {p};
  JointGraph joint(paths, {SE3{}}, {}, {});
  joint.add(JointRanges{}, {});
  joint.solve();
  EXPECT_TRUE(joint.T_map_body(0, 59).p.allFinite());
  EXPECT_TRUE(joint.T_map_body(0, 59).R.allFinite());
}

TEST(JointTilt, sigma_of_pitch_is_5_deg_without_inertial_data) {
  EXPECT_NEAR(pitch_sigma_deg(30, false), 5.0, 0.1);
}

/// Of a path whose first node is from before gravity was known.
double late_pitch_sigma_deg(std::uint32_t nodes) {
  const VehiclePath levelled = path(1, nodes);
  VehiclePath late(VehicleId{1});
  for (const VehiclePath::Node& node : levelled.nodes()) {
    Increment step = *node.step;
    step.levelled = step.node > 0;
    late.add(node.t, step);
  }
  return pitch_sigma_deg(late);
}

// An anchor that stands adds few nodes. Without the level that it knows since its second one, its
// tilt was stated as 5 deg: 8.6 m of height 98 m away.
TEST(JointTilt, first_node_with_a_known_gravity_levels_a_path_of_few_nodes) {
  EXPECT_NEAR(late_pitch_sigma_deg(3), 0.3 * std::sqrt(2.0), 0.01);         // 1/2
  EXPECT_NEAR(late_pitch_sigma_deg(22), 0.3 * std::sqrt(3.0 / 2.0), 0.01);  // 1/2 + 1/6
}

/// Both odoms are truly level and the same frame. The first vehicle takes gravity for tilted by
/// `error_deg`; each states `sigma_deg` of its own. @return tilt of the map
double map_tilt_deg(double error_deg, double first_sigma_deg, double second_sigma_deg) {
  constexpr std::uint32_t kNodes = 400;
  std::vector<VehiclePath> paths;
  for (std::uint16_t v = 0; v < 2; ++v) {
    const VehiclePath straight = path(v, kNodes);
    VehiclePath p(VehicleId{v});
    for (const VehiclePath::Node& node : straight.nodes()) {
      Increment step = *node.step;
      step.level_sigma_rad = kDegree * (v == 0 ? first_sigma_deg : second_sigma_deg);
      if (v == 0) {
        step.g_odom_mps2 =
            geometry::rotation_from_rpy(0.0, kDegree * error_deg, 0.0) * Vec3(0.0, 0.0, -9.81);
      }
      p.add(node.t, step);
    }
    paths.push_back(std::move(p));
  }
  JointGraph joint(paths, {T_map_odom_alone(paths[0]), SE3{}}, {}, {});
  for (const std::uint32_t k : {0U, 200U, 399U}) {
    Loop loop;
    loop.from = {VehicleId{0}, k};
    loop.to = {VehicleId{1}, k};
    loop.information = 1e10 * geometry::Mat6::Identity();
    joint.add_loop(k, loop);
  }
  joint.add(JointRanges{}, {});
  joint.solve();
  const Vec3 up_map = joint.T_map_body(0, 0).R * Vec3::UnitZ();
  return std::acos(std::min(1.0, up_map.z())) / kDegree;
}

// A vehicle that stands cannot tell gravity from the bias of its accelerometer; one that drives
// can. With the first vehicle's gravity alone the map stayed as tilted as that was wrong.
TEST(JointTilt, all_paths_determine_up_each_by_its_uncertainty) {
  // Weights 1 / (sigma^2 + 0.3^2).
  EXPECT_NEAR(map_tilt_deg(1.2, 0.9, 0.1), 1.2 * 1.111 / (1.111 + 10.0), 0.01);
  EXPECT_NEAR(map_tilt_deg(1.2, 0.1, 0.9), 1.2 * 10.0 / (1.111 + 10.0), 0.01);
  EXPECT_NEAR(map_tilt_deg(1.2, 0.0, 0.0), 0.6, 0.01);  // facts of earlier programs
}

/// At standstill and level for 20 s, degenerate: its accelerometer reads 9.81 m/s2 upward.
VehiclePath standing_degenerate() {
  VehiclePath p(VehicleId{0});
  for (std::uint32_t k = 0; k <= 20; ++k) {
    Increment step;
    step.node = k;
    step.begins = k == 0;
    step.keyframe = k;
    step.levelled = true;
    step.at_rest = true;
    step.degenerate = true;
    step.lidar_information.setIdentity();
    step.lidar_information *= 1e8;
    if (k > 0) step.inertial = second_at_rest(1e-4);
    p.add(Time::from_s(k), step);
  }
  return p;
}

// An earlier round estimated a pitch of one degree with a large sigma. The accelerometer corrects
// it in this and all later rounds. With gravity rotated with the path, it stayed at one degree.
TEST(JointTilt, gravity_factors_correct_a_tilt_of_the_separator_prior) {
  const std::vector<VehiclePath> paths = {standing_degenerate()};
  SeparatorPrior before;
  SeparatorNode node;
  node.node = 4;
  node.has_speed = true;
  node.x.T_odom_body.R = geometry::rotation_from_rpy(0.0, kDegree, 0.0);
  Eigen::Matrix<double, graph::kStateDim, 1> sigma;
  sigma << Vec3::Constant(2.0 * kDegree), Vec3::Constant(0.01), Vec3::Constant(0.01),
      Vec3::Constant(1e-5), Vec3::Constant(0.01);
  before.H = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  before.b.setZero(graph::kStateDim);
  before.nodes.push_back(node);
  SeparatorPath end;
  end.node = 4;
  end.T_map_body = node.x.T_odom_body;
  before.paths.push_back(end);
  ASSERT_TRUE(JointGraph::fits(before, paths, {}));
  JointGraph joint(paths, {end.T_map_body}, {}, {}, &before);
  joint.add(JointRanges{}, {});
  joint.solve();
  const Vec3 up_body = joint.T_map_body(0, 20).R.transpose() * Vec3::UnitZ();
  EXPECT_LT(std::acos(std::min(1.0, up_body.z())) / kDegree, 0.1);
}

/// Sigmas of pitch that a vehicle standing since its start (1.2 deg) and one that drives (0.3 deg)
/// have in the map, and the tilt of the first one's path against the second's.
struct Standing {
  double first_deg = 0.0, second_deg = 0.0, between_deg = 0.0;
};

/// Both are level. The first takes gravity for tilted by one degree; one loop says that they are
/// parallel in pitch, with this sigma.
Standing standing_beside_driving(double loop_deg) {
  std::vector<VehiclePath> paths;
  for (std::uint16_t v = 0; v < 2; ++v) {
    const VehiclePath straight = path(v, v == 0 ? 1 : 400);
    VehiclePath p(VehicleId{v});
    for (const VehiclePath::Node& node : straight.nodes()) {
      Increment step = *node.step;
      const double sigma_deg = v == 0 ? 1.2 * std::sqrt(0.5) : 0.3;  // 1/2: the first node's weight
      step.level_sigma_rad = kDegree * std::sqrt(sigma_deg * sigma_deg - 0.3 * 0.3);
      const Vec3 down(0.0, 0.0, -9.81);
      step.g_odom_mps2 =
          v == 0 ? Vec3(geometry::rotation_from_rpy(0.0, kDegree, 0.0) * down) : down;
      p.add(node.t, step);
    }
    paths.push_back(std::move(p));
  }
  JointGraph joint(paths, {T_map_odom_alone(paths[0]), SE3{}}, {}, {});
  Loop loop;
  loop.from = {VehicleId{0}, 0};
  loop.to = {VehicleId{1}, 0};
  loop.information = 1e10 * geometry::Mat6::Identity();
  loop.information(1, 1) = 1.0 / std::pow(kDegree * loop_deg, 2);
  joint.add_loop(0, loop);
  joint.add(JointRanges{}, {});
  joint.solve();
  const auto sigma_deg = [&joint](std::size_t p) {
    return std::sqrt(joint.covariance(p, 0)(1, 1)) / kDegree;
  };
  const Vec3 between =
      geometry::so3_log(joint.T_map_body(0, 0).R.transpose() * joint.T_map_body(1, 0).R);
  return {sigma_deg(0), sigma_deg(1), between.norm() / kDegree};
}

// The first pose's level was held at what the loops said, whatever the vehicle's own gravity, and
// stated as exact: in a corridor it was 1.8 degrees off, and the other vehicle stated 0.2.
TEST(JointTilt, of_a_vehicle_that_stood_is_weighed_against_the_loops) {
  const Standing weak = standing_beside_driving(1.2);
  EXPECT_NEAR(weak.between_deg, 1.0 * 1.44 / (1.44 + 1.44 + 0.09), 0.03);
  const Standing strong = standing_beside_driving(0.05);
  EXPECT_LT(strong.between_deg, 0.01);
  const Standing none = standing_beside_driving(60.0);
  EXPECT_NEAR(none.between_deg, 1.0, 0.03);
}

TEST(JointTilt, is_stated_relative_to_the_vehicle_that_knows_it_best) {
  const Standing weak = standing_beside_driving(1.2);
  EXPECT_NEAR(weak.first_deg, 1.2 / std::sqrt(2.0), 0.03);
  EXPECT_LT(weak.second_deg, 0.01);
  EXPECT_LT(standing_beside_driving(0.05).first_deg, 0.06);
}

}  // namespace
}  // namespace rali::fleet
