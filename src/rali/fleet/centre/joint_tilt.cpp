#include <cmath>
#include <numbers>
#include <utility>

#include "rali/fleet/centre/joint_graph.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::fleet {

using geometry::SE3;
using geometry::Vec3;
using graph::Seq;

namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
/// What fixes the map's frame: far below any real uncertainty.
constexpr double kHeld_rad = 1e-5;
constexpr double kHeld_m = 1e-4;

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
/// 1/6, 1/12, ... sum to 1, wherever a round ends between them. They begin with the first node that
/// knows gravity: a vehicle at standstill has few nodes.
void JointGraph::add_tilt(std::size_t path) {
  const auto& nodes = paths_[path].nodes();
  const Vec3 up_odom = paths_[path].up_odom();
  const auto every = static_cast<std::size_t>(settings_.tilt_every);
  const std::size_t first = first_levelled(path);
  double added = 0.0;  // information of the factors so far [1/rad^2]
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Increment& step = *nodes[k].step;
    const bool due = k < first ? k == 0 : (k - first) % every == 0 && step.levelled;
    if (!due) continue;
    const double nth = k < first ? 1.0 : 1.0 + static_cast<double>((k - first) / every);
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
  }
}

/// The map's origin and heading are those of one node. Its roll and pitch are estimated like all
/// others: a vehicle that has stood since its start knows its level to a degree only, since it
/// cannot tell gravity from the bias of the accelerometer, and the others know it better.
void JointGraph::hold_map(Seq seq, const SE3& T_map_body) {
  const Vec3 up_body = T_map_body.R.transpose() * Vec3::UnitZ();
  geometry::Mat6 information = geometry::Mat6::Zero();
  information.topLeftCorner<3, 3>() = up_body * up_body.transpose() / (kHeld_rad * kHeld_rad);
  information.diagonal().tail<3>().setConstant(1.0 / (kHeld_m * kHeld_m));
  graph_->add_pose_prior(seq, T_map_body, information);
  holds_map_ = seq;
}

/// First node of the path that knows its level best; of equal ones the first.
std::optional<Seq> JointGraph::level_reference() const {
  std::optional<Seq> best;
  double sigma_rad = 0.0;
  for (std::size_t path = 0; path < paths_.size(); ++path) {
    if (!T_map_odom_[path] || paths_[path].nodes().empty()) continue;
    const Increment* newest = paths_[path].newest_levelled();
    const Increment& step = newest != nullptr ? *newest : *paths_[path].nodes().front().step;
    const double own_rad = level_sigma_rad(step, settings_);
    if (best && !(own_rad < sigma_rad)) continue;
    best = seq(path, begin_[path]);
    sigma_rad = own_rad;
  }
  return best;
}

/// The error of the level that all vehicles share would move everything with the distance, and no
/// measurement between them shows it. So poses are stated relative to the level, as they are
/// relative to origin and heading.
std::vector<geometry::Mat6> JointGraph::covariances_in_map() const {
  graph::PoseGraph relative = *graph_;
  if (const std::optional<Seq> reference = level_reference()) {
    graph::GravityFactor level;
    level.i = *reference;
    level.up_body = relative.pose(*reference).R.transpose() * Vec3::UnitZ();
    level.sigma_rad = kHeld_rad;
    relative.add(level);
  }
  return relative.covariances();
}

}  // namespace rali::fleet
