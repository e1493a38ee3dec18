#include "rali/fleet/centre/joint_graph.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "rali/fleet/centre/joint_covariance.hpp"
#include "rali/fleet/centre/path_frames.hpp"
#include "rali/fleet/path/level.hpp"

namespace rali::fleet {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using graph::Seq;

namespace {

constexpr double kForceSigmaMin_mps2 = 1e-4;  ///< what an accelerometer resolves
constexpr double kRadPerDeg = std::numbers::pi / 180.0;

double inverse_square(double sigma) { return 1.0 / (sigma * sigma); }

/// The state of a node, transformed into the map.
graph::KeyframeState state_in_map(const Increment& step, const SE3& T_map_odom) {
  return {T_map_odom * step.T_odom_body, T_map_odom.R * step.v_odom_mps, step.gyro_bias_radps,
          step.accel_bias_mps2};
}

/// Whether the filter was corrected between two nodes, by ranges or by structure at the end of a
/// degenerate stretch. Its step is not the motion then: it differs by metres along a passage, and
/// in rotation and across it by the error of the bend.
bool is_corrected(const VehiclePath::Node& before, const VehiclePath::Node& node) {
  constexpr double kCorrected_m = 0.15;
  const auto v_body_mps = [](const Increment& step) {
    return Vec3(step.T_odom_body.R.transpose() * step.v_odom_mps);
  };
  const double half_s = 0.5 * (node.t - before.t).s();
  const Vec3 driven_m = half_s * (v_body_mps(*before.step) + v_body_mps(*node.step));
  const SE3 T = before.step->T_odom_body.inverse() * node.step->T_odom_body;
  return (T.p - driven_m).norm() > kCorrected_m;
}

}  // namespace

JointGraph::JointGraph(std::span<const VehiclePath> paths,
                       std::vector<std::optional<SE3>> T_map_odom, const JointSettings& settings,
                       const ranging::RangingSettings& ranging, const SeparatorPrior* before,
                       DegenerateSteps degenerate_steps)
    : paths_(paths),
      T_map_odom_(std::move(T_map_odom)),
      settings_(settings),
      ranging_(ranging),
      before_(before),
      degenerate_steps_(degenerate_steps),
      graph_(std::make_unique<graph::PoseGraph>(settings.graph)) {
  begin_ = begins_of(paths_, before_);
  std::size_t nodes = 0;
  bool held = before_ != nullptr;
  for (std::size_t path = 0; path < paths_.size(); ++path) {
    first_.push_back(nodes);
    if (!T_map_odom_[path] || paths_[path].nodes().empty()) continue;
    nodes += paths_[path].nodes().size() - begin_[path];
    add_path(path);
    if (!held) hold_map(seq(path, 0), T_map_body(path, 0));
    held = true;
  }
  first_.push_back(nodes);
}

Seq JointGraph::seq(std::size_t path, std::size_t node) const {
  return static_cast<Seq>(first_[path] + node - begin_[path]);
}

bool JointGraph::has_speed(Seq seq) const {
  return graph_->nodes()[static_cast<std::size_t>(seq)].dim == graph::kStateDim;
}

std::optional<Seq> JointGraph::seq(KeyframeId keyframe) const {
  for (std::size_t path = 0; path < paths_.size(); ++path) {
    if (paths_[path].vehicle() != keyframe.vehicle || !T_map_odom_[path]) continue;
    const std::optional<std::size_t> node = paths_[path].node_of(keyframe.seq);
    if (node && *node >= begin_[path]) return seq(path, *node);
  }
  return std::nullopt;
}

bool JointGraph::is_open(std::size_t path, std::size_t node) const {
  const Increment& step = *paths_[path].nodes()[node].step;
  return step.degenerate ||
         (paths_[path].ties_to_before(node) && is_loose(step.lidar_information, settings_.shape));
}

/// Velocity and biases are estimated only where the LiDAR does not fully constrain a step, and
/// around there: in degenerate stretches, or for a scan or two that are not marked degenerate.
std::vector<bool> JointGraph::inertial_nodes(std::size_t path) const {
  const auto& nodes = paths_[path].nodes();
  const auto margin = static_cast<std::size_t>(settings_.inertial_margin);
  std::vector<bool> inertial(nodes.size(), false);
  if (settings_.steps == StepWeight::kIsotropic || degenerate_steps_ == DegenerateSteps::kFilter) {
    return inertial;
  }
  // The node before the first one is included: it decides whether the inertial nodes begin there.
  const std::size_t from = begin_[path] > margin ? begin_[path] - margin - 1 : 0;
  for (std::size_t k = from; k < nodes.size(); ++k) {
    if (!is_open(path, k)) continue;
    const std::size_t begin = k > margin ? k - margin : 0;
    const std::size_t end = std::min(nodes.size(), k + margin + 1);
    for (std::size_t i = begin; i < end; ++i) inertial[i] = nodes[i].step->levelled;
  }
  if (before_ == nullptr) return inertial;
  // A node keeps the unknowns it had when its round ended.
  for (const SeparatorNode& known : before_->nodes) {
    if (known.stream != stream_of(paths_[path])) continue;
    if (const auto k = paths_[path].index_of(known.node)) inertial[*k] = known.has_speed;
  }
  return inertial;
}

void JointGraph::add_path(std::size_t path) {
  const auto& nodes = paths_[path].nodes();
  const std::vector<bool> inertial = inertial_nodes(path);
  for (std::size_t k = begin_[path]; k < nodes.size(); ++k) {
    const graph::KeyframeState state = state_in_map(*nodes[k].step, *T_map_odom_[path]);
    if (inertial[k]) {
      graph_->add_state(state);
      const bool begins =
          k == 0 || !inertial[k - 1] || !nodes[k].step->inertial || !paths_[path].ties_to_before(k);
      if (begins) add_start_of_inertial(path, k);
    } else {
      graph_->add_pose(state.T_odom_body);
    }
  }
  add_steps(path);
  add_standstill(path);
  add_initialised(path);
  add_tilt(path);
}

/// An accelerometer measures bias and gravity together: known is their sum, f = b + g R^T up. The
/// level is left to the gravity factors (joint_tilt.cpp). With a prior on the bias itself each
/// inertial stretch would measure the level once more, with the same error as all others, and
/// bend the path between them. The vehicle's filter knows the sum from the whole drive, this
/// stretch alone would have to learn it anew.
void JointGraph::add_start_of_inertial(std::size_t path, std::size_t node) {
  const auto& nodes = paths_[path].nodes();
  const Increment& step = *nodes[node].step;
  const bool goes_on = node + 1 < nodes.size() && nodes[node + 1].step->inertial;
  const geometry::Mat3 R_imu_body =
      goes_on ? geometry::Mat3(nodes[node + 1].step->inertial->T_body_imu.R.transpose())
              : geometry::Mat3::Identity();
  const double g_mps2 = step.g_odom_mps2.norm();
  graph::PriorFactor prior;
  prior.i = seq(path, node);
  prior.mean = graph_->state(prior.i);
  const auto set = [&prior](int first, double sigma) {
    prior.information.diagonal().segment<3>(first).setConstant(inverse_square(sigma));
  };
  set(graph::kVel, settings_.start_speed_sigma_mps);
  set(graph::kGyroBias, settings_.start_gyro_bias_sigma_radps);
  const Vec3 up_odometry = -(step.T_odom_body.R.transpose() * step.g_odom_mps2).normalized();
  const Vec3 up_map = prior.mean.T_odom_body.R.transpose() * Vec3::UnitZ();
  prior.mean.accel_bias_mps2 += g_mps2 * R_imu_body * (up_odometry - up_map);
  Eigen::Matrix<double, 3, graph::kStateDim> H = decltype(H)::Zero();
  H.middleCols<3>(graph::kTheta) = g_mps2 * R_imu_body * geometry::skew(up_map);
  H.middleCols<3>(graph::kAccelBias).setIdentity();
  const double sigma_mps2 = step.force_sigma_mps2 > 0.0
                                ? std::max(kForceSigmaMin_mps2, step.force_sigma_mps2)
                                : settings_.start_accel_bias_sigma_mps2;
  prior.information += inverse_square(sigma_mps2) * H.transpose() * H;
  graph_->add(prior);
}

/// The path's first node that knows gravity; the number of its nodes if none does.
std::size_t JointGraph::first_levelled(std::size_t path) const {
  const auto& nodes = paths_[path].nodes();
  const auto levelled = [](const VehiclePath::Node& node) { return node.step->levelled; };
  const auto first = std::find_if(nodes.begin(), nodes.end(), levelled);
  return static_cast<std::size_t>(first - nodes.begin());
}

/// Nodes from before gravity is known have no inertial step, so nothing ties them along a passage.
/// But the initialisation follows the motion since the first scan once more, with inertial data:
/// the first node with gravity states its position relative to the first one. It is 0.01 m for a
/// vehicle that stood, and large for one that started in motion.
void JointGraph::add_initialised(std::size_t path) {
  const auto& nodes = paths_[path].nodes();
  if (settings_.steps == StepWeight::kIsotropic) return;
  if (begin_[path] > 0) return;  // in the separator prior
  const std::size_t k = first_levelled(path);
  if (k == 0 || k == nodes.size()) return;
  for (std::size_t i = 1; i <= k; ++i) {
    if (nodes[i].step->begins) return;
  }
  const SE3& first = nodes[0].step->T_odom_body;
  graph::RelativePoseFactor factor{seq(path, 0), seq(path, k),
                                   first.inverse() * nodes[k].step->T_odom_body};
  geometry::Mat3 P_m2 = nodes[k].step->covariance.bottomRightCorner<3, 3>();
  P_m2.diagonal().array() += settings_.shape.loose_m * settings_.shape.loose_m;
  factor.information.bottomRightCorner<3, 3>() = first.R.transpose() * P_m2.inverse() * first.R;
  if (factor.information.allFinite()) graph_->add(factor);
}

void JointGraph::add_steps(std::size_t path) {
  const auto& nodes = paths_[path].nodes();
  for (std::size_t k = begin_[path] + 1; k < nodes.size(); ++k) {
    const Increment& before = *nodes[k - 1].step;
    const Increment& step = *nodes[k].step;
    graph::RelativePoseFactor shape;
    shape.i = seq(path, k - 1);
    shape.j = seq(path, k);
    shape.T_i_j = before.T_odom_body.inverse() * step.T_odom_body;
    const bool inertial =
        paths_[path].ties_to_before(k) && step.inertial && has_speed(shape.i) && has_speed(shape.j);
    if (step.begins) {
      shape.information.diagonal().head<3>().setConstant(inverse_square(settings_.lost_rad));
      shape.information.diagonal().tail<3>().setConstant(inverse_square(settings_.lost_m));
    } else if (settings_.steps == StepWeight::kIsotropic) {
      shape.information.diagonal().head<3>().setConstant(
          inverse_square(kRadPerDeg * settings_.isotropic_deg));
      shape.information.diagonal().tail<3>().setConstant(inverse_square(settings_.isotropic_m));
    } else {
      shape.information =
          shape_information(step.lidar_information, before.T_odom_body, settings_.shape,
                            unseen_variance_m2(before.covariance, step.covariance));
      const ShapeSettings& s = settings_.shape;
      const bool by_filter = degenerate_steps_ == DegenerateSteps::kFilter;
      if (by_filter || !inertial) {
        tie_by_filter(
            shape.information, before.covariance, step.covariance,
            by_filter ? LeastSigma{s.loose_rad, s.loose_m} : LeastSigma{s.known_rad, s.gap_m});
      }
    }
    if (inertial) add_regained(path, k, shape);
    if (!inertial || !is_corrected(nodes[k - 1], nodes[k])) graph_->add(shape);
    if (inertial) {
      graph::InertialFactor factor = *step.inertial;
      factor.i = shape.i;
      factor.j = shape.j;
      // Gravity is vertical in the map, however a separator prior has tilted the path. The path's
      // own gravity vector would rotate with that tilt and preserve it.
      factor.g_odom_mps2 = Vec3(0.0, 0.0, -step.g_odom_mps2.norm());
      graph_->add(factor);
    }
  }
}

void JointGraph::add_standstill(std::size_t path) {
  const auto& nodes = paths_[path].nodes();
  for (std::size_t k = begin_[path]; k < nodes.size(); ++k) {
    if (!nodes[k].step->at_rest) continue;
    graph::StandstillFactor rest;
    rest.i = seq(path, k);
    const bool stays =
        k + 1 < nodes.size() && nodes[k + 1].step->at_rest && !nodes[k + 1].step->begins;
    if (stays) rest.next = seq(path, k + 1);
    if (stays || has_speed(rest.i)) graph_->add(rest);
  }
}

/// The last node before `node` that knows the position along the axis as well as `found`. Nothing
/// within this chain of steps, or before the separator: nothing.
std::optional<std::size_t> JointGraph::known_before(std::size_t path, std::size_t node,
                                                    const Regained& found) const {
  const double loose_m2 = settings_.shape.loose_m * settings_.shape.loose_m;
  for (std::size_t k = node; k > begin_[path] && paths_[path].ties_to_before(k); --k) {
    const Increment& step = *paths_[path].nodes()[k - 1].step;
    const double variance_m2 = position_variance_m2(step.covariance, found.axis_odom);
    if (variance_m2 <= found.variance_m2 + loose_m2) return k - 1;
  }
  return std::nullopt;
}

/// At the end of a degenerate stretch a scan may find the map from before the stretch again. The
/// filter's pose then steps by the error of the whole stretch, which the last step did not make:
/// the pose is constrained to the last node that knew this direction as well, and the stretch
/// between distributes the error. Structure seen for the first time gives nothing of this: the
/// variance stays.
/// @param shape of the step to the node; gives no constraint along such a direction any more
void JointGraph::add_regained(std::size_t path, std::size_t node,
                              graph::RelativePoseFactor& shape) {
  const Increment& step = *paths_[path].nodes()[node].step;
  const Increment& before = *paths_[path].nodes()[node - 1].step;
  const double loose_m2 = settings_.shape.loose_m * settings_.shape.loose_m;
  for (const Regained& found :
       regained(before.covariance, step.covariance, step.lidar_information, settings_.shape)) {
    const std::optional<std::size_t> known = known_before(path, node, found);
    if (!known) continue;
    const Increment& from = *paths_[path].nodes()[*known].step;
    const double grown_m2 =
        found.variance_m2 - position_variance_m2(from.covariance, found.axis_odom);
    const Vec3 axis = from.T_odom_body.R.transpose() * found.axis_odom;
    graph::RelativePoseFactor bridge{seq(path, *known), shape.j,
                                     from.T_odom_body.inverse() * step.T_odom_body};
    bridge.information.bottomRightCorner<3, 3>() =
        axis * axis.transpose() / (std::max(0.0, grown_m2) + loose_m2);
    graph_->add(bridge);
    const Vec3 axis_before = before.T_odom_body.R.transpose() * found.axis_odom;
    Mat6 others = Mat6::Identity();
    others.bottomRightCorner<3, 3>() -= axis_before * axis_before.transpose();
    shape.information = others * shape.information * others;
  }
}

/// Bodies are not level at their start: the prior relates their level frames, and constrains the
/// rotation about the vertical axis only.
void JointGraph::add(const StartPrior& prior) {
  if (!T_map_odom_[prior.relative_to] || !T_map_odom_[prior.path]) return;
  if (begin_[prior.relative_to] > 0 || begin_[prior.path] > 0) return;  // in the separator prior
  const auto T_body_level = [this](std::size_t path) {
    const SE3& T = paths_[path].nodes().front().step->T_odom_body;
    return T.inverse() * level_start(T, paths_[path].up_odom());
  };
  graph::RelativePoseFactor factor;
  factor.i = seq(prior.relative_to, 0);
  factor.j = seq(prior.path, 0);
  factor.T_i_j =
      T_body_level(prior.relative_to) * prior.T_relative_path * T_body_level(prior.path).inverse();
  const Vec3 up_body = paths_[prior.path].nodes().front().step->T_odom_body.R.transpose() *
                       paths_[prior.path].up_odom();
  factor.information.topLeftCorner<3, 3>() =
      inverse_square(prior.sigma_rad) * up_body * up_body.transpose();
  factor.information.diagonal().tail<3>().setConstant(inverse_square(prior.sigma_m));
  graph_->add(factor);
}

void JointGraph::add_loop(std::uint64_t id, const Loop& loop) {
  const std::optional<Seq> i = seq(loop.from);
  const std::optional<Seq> j = seq(loop.to);
  if (!i || !j) return;
  graph_->add(graph::LoopFactor{id, {*i, *j, loop.T_from_to, loop.information}});
}

void JointGraph::stop_on(StopFlag stop) {
  stop_ = stop;
  graph_->stop_on(stop);
}

void JointGraph::solve() {
  covariances_.clear();
  const int iterations = any_degenerate() ? settings_.iterations : settings_.iterations_easy;
  for (int round = 0; round < settings_.rounds && !stop_.raised(); ++round) {
    if (graph_->loops().empty()) {
      graph_->solve(iterations);
    } else {
      graph_->solve_full();
    }
    if (round + 1 < settings_.rounds) reclassify_outliers();
  }
}

SE3 JointGraph::T_map_body(std::size_t path, std::size_t node) const {
  return graph_->state(seq(path, node)).T_odom_body;
}

/// The graph does not contain the error of the vehicle's own map. In observable directions it is
/// the filter's covariance. The first scan of a map was compared with none: its whole filter
/// covariance is the map's.
Mat6 JointGraph::covariance(std::size_t path, std::size_t node) {
  const Increment& step = *paths_[path].nodes()[node].step;
  Mat6 turn = Mat6::Identity();
  turn.bottomRightCorner<3, 3>() = T_map_odom_[path]->R;
  const Mat6 fraction =
      node == 0 ? Mat6(Mat6::Identity()) : known_fraction(step.lidar_information, settings_.shape);
  const Mat6 of_map = turn * fraction * step.covariance * fraction.transpose() * turn.transpose();
  if (covariances_.empty()) covariances_ = covariances_in_map();
  steps_.resize(paths_.size());
  if (steps_[path].empty()) steps_[path] = shape_covariances(paths_[path], settings_);
  const Mat6 of_steps = turn * steps_[path][node] * turn.transpose();
  return joint_covariance(covariances_[seq(path, node)], of_steps, of_map);
}

}  // namespace rali::fleet
