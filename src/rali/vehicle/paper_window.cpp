#include "rali/vehicle/paper_window.hpp"

#include <algorithm>
#include <numbers>

#include "rali/graph/pose_graph.hpp"
#include "rali/ranging/range_correction.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
/// Sigma that fixes the oldest keyframe [m and rad]; zero would make the equations singular.
constexpr double kHeld = 1e-4;
/// Sigmas of its velocity and biases, by earlier data.
constexpr double kSpeedMps = 0.1;
constexpr double kGyroRadps = 1e-3;
constexpr double kAccelMps2 = 0.02;

double information(double sigma) { return 1.0 / (sigma * sigma); }

graph::KeyframeState state_of(const PaperWindow::Node& node) {
  graph::KeyframeState x;
  x.T_odom_body = node.T_odom_body;
  x.v_odom_mps = node.motion.v_odom_imu_mps;
  x.gyro_bias_radps = node.motion.bias.gyro_radps;
  x.accel_bias_mps2 = node.motion.bias.accel_mps2;
  return x;
}

/// Prior on roll and pitch of every keyframe. The oldest, and one without an inertial factor, get
/// priors on velocity and biases too; the oldest also on its pose.
graph::PriorFactor prior_of(const PaperWindow::Node& node, graph::Seq number, double level_rad,
                            bool oldest) {
  graph::PriorFactor prior;
  prior.i = number;
  prior.mean = state_of(node);
  // The graph's own estimates would count the same evidence again with every keyframe.
  prior.mean.v_odom_mps = node.reported.v_odom_imu_mps;
  prior.mean.gyro_bias_radps = node.reported.bias.gyro_radps;
  prior.mean.accel_bias_mps2 = node.reported.bias.accel_mps2;
  const Vec3 up_body = node.T_odom_body.R.row(2).transpose();
  const Mat3 level = Mat3::Identity() - up_body * up_body.transpose();
  prior.information.topLeftCorner<3, 3>() = information(level_rad) * level;
  if (oldest) prior.information.diagonal().head<6>().setConstant(information(kHeld));
  if (oldest || !node.inertial) {
    prior.information.diagonal().segment<3>(graph::kVel).setConstant(information(kSpeedMps));
    prior.information.diagonal().segment<3>(graph::kGyroBias).setConstant(information(kGyroRadps));
    prior.information.diagonal().segment<3>(graph::kAccelBias).setConstant(information(kAccelMps2));
  }
  return prior;
}

/// Where the LiDAR constrains a step, its sd is smaller by this factor.
constexpr double kFirm = 10.0;

/// Constant sd, in all directions or along the degenerate one alone.
graph::RelativePoseFactor odometry_factor(const PaperWindow::Node& before,
                                          const PaperWindow::Node& node, PaperSteps steps,
                                          const ranging::PaperRangeSettings& settings) {
  graph::RelativePoseFactor factor;
  factor.T_i_j = node.T_previous_this;
  const bool all = steps == PaperSteps::kIsotropic || (node.degenerate && !node.e3_odom);
  const double firm = all ? 1.0 : kFirm;
  factor.information.diagonal().head<3>().setConstant(
      information(settings.lidar_sd_deg * kDegree / firm));
  factor.information.diagonal().tail<3>().setConstant(information(settings.lidar_sd_m / firm));
  if (all || !node.e3_odom) return factor;
  const Vec3 e3 = before.T_odom_body.R.transpose() * *node.e3_odom;
  const double less = information(settings.lidar_sd_m / firm) - information(settings.lidar_sd_m);
  factor.information.bottomRightCorner<3, 3>() -= less * e3 * e3.transpose();
  return factor;
}

graph::RangeFactor range_factor(const PaperWindow::Node& node, graph::Seq number,
                                const ranging::PaperRangeSettings& settings) {
  graph::RangeFactor factor;
  factor.id = node.seq;
  factor.t = node.t;
  factor.i = number;
  factor.p_i_m = node.range->p_body_m;
  factor.p_fixed_odom_m = node.range->p_odom_peer_m;
  // In the paper the range is one in the plane of the vehicle.
  if (settings.range_2d == ranging::PaperRange2d::kFlat) {
    factor.p_fixed_odom_m.z() = (node.T_odom_body * node.range->p_body_m).z();
  }
  factor.range_m = node.range->range_m;
  factor.sigma_m = settings.range_sigma_m;
  return factor;
}

void take(const graph::KeyframeState& x, PaperWindow::Node& node) {
  const bool finite = x.T_odom_body.R.allFinite() && x.T_odom_body.p.allFinite() &&
                      x.v_odom_mps.allFinite() && x.gyro_bias_radps.allFinite() &&
                      x.accel_bias_mps2.allFinite();
  if (!finite) return;
  node.T_odom_body = x.T_odom_body;
  node.motion = {x.v_odom_mps, {x.gyro_bias_radps, x.accel_bias_mps2}};
}

}  // namespace

void PaperWindow::add(Node node, bool degenerate) {
  node.degenerate = degenerate;
  node.room_m2 = degenerate ? settings_.lidar_sd_m * settings_.lidar_sd_m : 0.0;
  node.reported = node.motion;
  if (nodes_.empty()) {
    node.inertial.reset();
  } else {
    node.T_previous_this = nodes_.back().T_odom_body.inverse() * node.T_odom_body;
  }
  nodes_.push_back(std::move(node));
  while (nodes_.size() > static_cast<std::size_t>(settings_.window_keyframes)) nodes_.pop_front();
}

void PaperWindow::shift_newest(const Vec3& shift_odom_m) {
  // Starts after the last keyframe that was corrected; the oldest is fixed.
  std::size_t first = nodes_.size() - 1;
  if (settings_.fraction == ranging::PaperFraction::kKeyframes) {
    while (first > 1 && !nodes_[first - 1].corrected) --first;
  }
  std::vector<double> rooms_m2;
  for (std::size_t i = first; i < nodes_.size(); ++i) rooms_m2.push_back(nodes_[i].room_m2);
  rooms_m2.back() = settings_.lidar_sd_m * settings_.lidar_sd_m;
  const std::vector<double> fractions = ranging::share_shift(rooms_m2, 1.0);
  for (std::size_t i = first; i < nodes_.size(); ++i) {
    nodes_[i].T_odom_body.p += fractions[i - first] * shift_odom_m;
  }
  nodes_.back().corrected = true;
  if (settings_.correct_then_factor == ranging::PaperThenFactor::kGuess) return;
  for (std::size_t i = std::max<std::size_t>(first, 1); i < nodes_.size(); ++i) {
    nodes_[i].T_previous_this = nodes_[i - 1].T_odom_body.inverse() * nodes_[i].T_odom_body;
  }
}

void PaperWindow::solve() {
  const bool any =
      std::any_of(nodes_.begin(), nodes_.end(), [](const Node& n) { return n.range.has_value(); });
  if (!any || nodes_.size() < 2) return;
  graph::GraphSettings how;
  how.huber_sd = 1e6;  // the paper's factors are not robust
  graph::PoseGraph graph(how);
  std::vector<graph::Seq> numbers;
  for (const Node& node : nodes_) numbers.push_back(graph.add_state(state_of(node)));
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    graph.add(prior_of(node, numbers[i], settings_.level_sd_deg * kDegree, i == 0));
    if (i > 0) {
      graph::RelativePoseFactor step = odometry_factor(nodes_[i - 1], node, steps_, settings_);
      step.i = numbers[i - 1];
      step.j = numbers[i];
      graph.add(step);
    }
    if (i > 0 && node.inertial) {
      graph::InertialFactor factor = *node.inertial;
      factor.i = numbers[i - 1];
      factor.j = numbers[i];
      graph.add(factor);
    }
    if (node.range) graph.add(range_factor(node, numbers[i], settings_));
  }
  graph.solve(settings_.iterations);
  for (std::size_t i = 0; i < nodes_.size(); ++i) take(graph.state(numbers[i]), nodes_[i]);
}

}  // namespace rali::vehicle
