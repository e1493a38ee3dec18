#include "rali/vehicle/paper_window.hpp"

#include <algorithm>
#include <numbers>

#include "rali/graph/local_graph.hpp"
#include "rali/ranging/range_correction.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
/// The oldest keyframe is held so firmly [m and rad]; exactly would leave the equations singular.
constexpr double kHeld = 1e-4;

double information(double sigma) { return 1.0 / (sigma * sigma); }

/// The graph's keyframes have velocities and biases too: nothing here concerns them.
graph::PriorFactor level_prior(const PaperWindow::Node& node, double sigma_rad) {
  graph::PriorFactor prior;
  prior.i = node.seq;
  prior.mean.T_odom_body = node.T_odom_body;
  const Vec3 up_body = node.T_odom_body.R.row(2).transpose();
  const Mat3 level = Mat3::Identity() - up_body * up_body.transpose();
  prior.information.topLeftCorner<3, 3>() = information(sigma_rad) * level;
  prior.information.bottomRightCorner<9, 9>().setIdentity();
  return prior;
}

graph::RelativePoseFactor odometry_factor(const PaperWindow::Node& before,
                                          const PaperWindow::Node& node,
                                          const ranging::PaperRangeSettings& settings) {
  graph::RelativePoseFactor factor;
  factor.i = before.seq;
  factor.j = node.seq;
  factor.T_i_j = node.T_previous_this;
  factor.information.diagonal().head<3>().setConstant(information(settings.lidar_sd_deg * kDegree));
  factor.information.diagonal().tail<3>().setConstant(information(settings.lidar_sd_m));
  return factor;
}

graph::RangeFactor range_factor(const PaperWindow::Node& node,
                                const ranging::PaperRangeSettings& settings) {
  graph::RangeFactor factor;
  factor.id = node.seq;
  factor.t = node.t;
  factor.i = node.seq;
  factor.p_i_m = node.range->p_body_m;
  factor.p_fixed_odom_m = node.range->p_odom_peer_m;
  // As printed the range is one in the plane of the vehicle.
  if (settings.range_2d == ranging::PaperRange2d::kFlat) {
    factor.p_fixed_odom_m.z() = (node.T_odom_body * node.range->p_body_m).z();
  }
  factor.range_m = node.range->range_m;
  factor.sigma_m = settings.range_sigma_m;
  return factor;
}

}  // namespace

void PaperWindow::add(std::uint32_t seq, Time t, const SE3& T_odom_body, const Mat6& covariance,
                      bool degenerate) {
  Node node;
  node.seq = seq;
  node.t = t;
  node.T_odom_body = T_odom_body;
  node.covariance = covariance;
  if (degenerate) node.room_m2 = settings_.lidar_sd_m * settings_.lidar_sd_m;
  if (!nodes_.empty()) node.T_previous_this = nodes_.back().T_odom_body.inverse() * T_odom_body;
  nodes_.push_back(node);
  while (nodes_.size() > static_cast<std::size_t>(settings_.window_keyframes)) nodes_.pop_front();
}

void PaperWindow::shift_newest(const Vec3& shift_odom_m) {
  // From behind the last keyframe that was corrected; the oldest is held.
  std::size_t first = nodes_.size() - 1;
  if (settings_.share == ranging::PaperShare::kKeyframes) {
    while (first > 1 && !nodes_[first - 1].corrected) --first;
  }
  std::vector<double> rooms_m2;
  for (std::size_t i = first; i < nodes_.size(); ++i) rooms_m2.push_back(nodes_[i].room_m2);
  rooms_m2.back() = settings_.lidar_sd_m * settings_.lidar_sd_m;
  const std::vector<double> shares = ranging::share_shift(rooms_m2, 1.0);
  for (std::size_t i = first; i < nodes_.size(); ++i) {
    nodes_[i].T_odom_body.p += shares[i - first] * shift_odom_m;
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
  graph::LocalGraphSettings how;
  how.iterations = settings_.iterations;
  how.huber_sd = 1e6;  // the paper's factors are not robust
  graph::LocalGraph graph(how);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    graph::KeyframeState initial;
    initial.T_odom_body = node.T_odom_body;
    graph.add_keyframe(node.seq, node.t, initial);
    graph::PriorFactor prior = level_prior(node, settings_.level_sd_deg * kDegree);
    if (i == 0) prior.information.diagonal().head<6>().setConstant(information(kHeld));
    graph.add(prior);
    if (i > 0) graph.add(odometry_factor(nodes_[i - 1], node, settings_));
    if (node.range) graph.add(range_factor(node, settings_));
  }
  graph.solve(settings_.iterations);
  for (Node& node : nodes_) {
    const SE3& T = graph.state(node.seq).T_odom_body;
    if (T.R.allFinite() && T.p.allFinite()) node.T_odom_body = T;
  }
}

}  // namespace rali::vehicle
