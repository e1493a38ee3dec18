#include <cmath>
#include <numbers>
#include <utility>

#include "rali/fleet/centre/joint_graph.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::fleet {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

}  // namespace

double level_sigma_rad(double stated_rad, const JointSettings& settings) {
  return std::hypot(stated_rad, kRadPerDeg * settings.tilt_deg);
}

double level_sigma_rad(const Increment& step, const JointSettings& settings) {
  return step.levelled ? level_sigma_rad(step.level_sigma_rad, settings)
                       : kRadPerDeg * settings.tilt_unlevelled_deg;
}

/// Gravity from the vehicle's odometry, as certain as the odometry states it. Its error is common
/// to all nodes, so all factors together must not carry more information than one. The weights 1/2,
/// 1/6, 1/12, ... sum to 1, wherever a round ends between them.
void JointGraph::add_tilt(std::size_t path) {
  const auto& nodes = paths_[path].nodes();
  const Vec3 up_odom = paths_[path].up_odom();
  const auto every = static_cast<std::size_t>(settings_.tilt_every);
  double added = 0.0;  // information of the factors so far [1/rad^2]
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Increment& step = nodes[k].step;
    if (k % every != 0 || (!step.levelled && k > 0)) continue;
    const double nth = 1.0 + static_cast<double>(k / every);
    const double fraction = step.levelled ? nth / (nth + 1.0) : 1.0;
    const double total = fraction / std::pow(level_sigma_rad(step, settings_), 2);
    if (total <= added) continue;
    const double information = total - std::exchange(added, total);
    if (k < begin_[path]) continue;  // in the separator prior
    graph::GravityFactor gravity;
    gravity.i = seq(path, k);
    gravity.up_body = step.T_odom_body.R.transpose() * up_odom;
    gravity.sigma_rad = 1.0 / std::sqrt(information);
    graph_->add(gravity);
    gravity_.push_back(gravity);
  }
}

/// The first pose defines the map's frame, but up in it is determined by all paths: the first
/// vehicle may have stood since its start, where gravity and the bias of the accelerometer cannot
/// be told apart. A separator prior contains the map's frame with its level.
void JointGraph::level() {
  if (before_ != nullptr) return;
  Vec3 up_map = Vec3::Zero();
  for (const graph::GravityFactor& gravity : gravity_) {
    up_map += graph_->pose(gravity.i).R * gravity.up_body / std::pow(gravity.sigma_rad, 2);
  }
  if (up_map.z() <= 0.0) return;
  SE3 T;
  T.R = geometry::rotation_between(up_map.normalized(), Vec3::UnitZ());
  const Vec3 first_m = graph_->pose(graph_->nodes().front().seq).p;
  T.p = first_m - T.R * first_m;
  graph_->transform(T);
}

}  // namespace rali::fleet
