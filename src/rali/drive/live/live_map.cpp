#include "rali/drive/live/live_map.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>

#include "rali/fleet/centre/joint_graph.hpp"
#include "rali/fleet/centre/path_frames.hpp"

namespace rali::drive {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

namespace {

/// Time of the first scheduled table, and the growth factor of the run time until the next one: all
/// tables together cost a few times as much as the last one.
constexpr double kFirst_s = 5.0, kGrowth = 1.3;

/// Time to wait for the first vehicle; then the first one with a path defines the map.
constexpr double kWait_s = 5.0;

/// Time to wait for gravity. If inertial data do not give it by then, they may never.
constexpr double kWaitLevel_s = 10.0;

/// Corrections of the filter that odom leaves out (vehicle/odom_frame.hpp) are decimetres.
constexpr double kContradiction_m = 0.3;

constexpr double kStep_m = 0.01, kStep_rad = 0.5 * std::numbers::pi / 180.0;

/// Jacobian of a pose's error for another pose rigidly attached to it (geometry::boxplus).
Mat6 carried_by(const SE3& T_outer_from, const SE3& T_outer_to) {
  const SE3 T_from_to = T_outer_from.inverse() * T_outer_to;
  Mat6 J = Mat6::Identity();
  J.topLeftCorner<3, 3>() = T_from_to.R.transpose();
  J.bottomLeftCorner<3, 3>() = -T_outer_from.R * geometry::skew(T_from_to.p);
  return J;
}

/// The positive semidefinite part of a symmetric matrix.
Mat6 positive(const Mat6& m) {
  const Eigen::SelfAdjointEigenSolver<Mat6> eigen(m);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

/// The covariance of a pose in a rotated frame: rotation is perturbed in the body.
Mat6 turned(const geometry::Mat3& R, const Mat6& covariance) {
  Mat6 J = Mat6::Identity();
  J.bottomRightCorner<3, 3>() = R;
  return J * covariance * J.transpose();
}

}  // namespace

LiveMap::LiveMap(std::size_t vehicles, const fleet::FleetSettings& settings,
                 fleet::FleetKnowledge known)
    : joint_(settings.joint), centre_(settings, std::move(known)), members_(vehicles) {}

void LiveMap::add(const fleet::FactPtr& fact) {
  // A single vehicle has no peer to compare points with.
  if (members_.size() == 1 && std::holds_alternative<fleet::KeyframePoints>(fact->body)) return;
  centre_.add(fact);
}

/// The lowest number with a path; empty while a lower one is waited for.
std::optional<VehicleId> LiveMap::reference(Time now) const {
  const auto& paths = centre_.paths();
  if (paths.empty()) return std::nullopt;
  const VehicleId first = paths.front().vehicle();
  const bool waited = begin_ && (now - *begin_).s() >= kWait_s;
  return first.value == 0 || waited ? std::optional(first) : std::nullopt;
}

bool LiveMap::is_due(Time now) {
  const auto& paths = centre_.paths();
  if (paths.empty()) return false;
  if (!begin_) begin_ = now;
  const auto levelled = static_cast<std::size_t>(
      std::count_if(paths.begin(), paths.end(), [](const auto& path) { return path.levelled(); }));
  const bool came = paths.size() != std::exchange(paths_, paths.size());
  const bool rose = levelled != std::exchange(levelled_, levelled);
  return came || rose || !due_ || now >= *due_;
}

void LiveMap::advance(Time now, Executor& executor) {
  if (!is_due(now)) return;
  const auto first = reference(now);
  if (!first) return;
  const bool any = std::any_of(members_.begin(), members_.end(),
                               [](const Member& m) { return m.entry.has_value(); });
  if (!any) reference_ = *first;
  solve(now, executor);
  const double age_s = std::max(kFirst_s, kGrowth * (now - *begin_).s());
  due_ = *begin_ + Duration::from_s(age_s);
  t_table_ = now;
}

void LiveMap::solve(Time now, Executor& executor) {
  if (members_.size() > 1) return take(centre_.estimate(executor), now);
  members_[0].entry = Entry{fleet::T_map_odom_alone(centre_.paths().front()), {}};
  ++members_[0].tables;
}

void LiveMap::take(const fleet::FleetEstimate& estimate, Time now) {
  const auto of = [&](VehicleId id) {
    return std::find_if(estimate.frames.begin(), estimate.frames.end(),
                        [&](const fleet::VehicleFrame& f) { return f.vehicle == id; });
  };
  const auto reference = of(reference_);
  if (reference == estimate.frames.end()) return;
  level_sigma_rad_ = level_sigma_of(estimate, reference->group);
  for (const fleet::VehicleFrame& frame : estimate.frames) {
    if (frame.vehicle.value >= members_.size()) continue;
    if (frame.group != reference->group) {
      withdraw(frame, now);
      continue;
    }
    Member& member = members_[frame.vehicle.value];
    member.entry = entry_of(estimate, frame);
    member.T_map_odom_table.reset();
    if (!member.t_joined) member.t_joined = now;
    ++member.tables;
  }
}

/// All vehicles of a group determine together where up is in its map.
double LiveMap::level_sigma_of(const fleet::FleetEstimate& estimate, std::size_t group) const {
  double information = 0.0;
  for (const fleet::VehicleFrame& frame : estimate.frames) {
    if (frame.group != group) continue;
    const fleet::VehiclePath* path = fleet::path_of(centre_.paths(), {frame.vehicle, frame.epoch});
    const fleet::Increment* step = path != nullptr ? path->newest_levelled() : nullptr;
    if (step != nullptr) information += std::pow(fleet::level_sigma_rad(*step, joint_), -2);
  }
  return information > 0.0 ? 1.0 / std::sqrt(information) : 0.0;
}

/// Poses in a frame that the facts contradict are worse than none: a vehicle without a live pose
/// navigates by its odometry.
void LiveMap::withdraw(const fleet::VehicleFrame& frame, Time now) {
  Member& member = members_[frame.vehicle.value];
  if (!member.entry) return;
  const Time t_joined = member.t_joined.value_or(now);
  withdrawals_.push_back({frame.vehicle, t_joined, now, frame.waits_for});
  member = Member{};
}

std::vector<Withdrawal> LiveMap::take_withdrawals() { return std::exchange(withdrawals_, {}); }

/// A vehicle continues from its last keyframe in the table.
LiveMap::Entry LiveMap::entry_of(const fleet::FleetEstimate& estimate,
                                 const fleet::VehicleFrame& frame) const {
  Entry entry{frame.T_map_odom, {}};
  const auto path =
      std::find_if(centre_.paths().begin(), centre_.paths().end(),
                   [&](const fleet::VehiclePath& p) { return p.vehicle() == frame.vehicle; });
  const VehicleId next{static_cast<std::uint16_t>(frame.vehicle.value + 1)};
  auto last = estimate.keyframes.lower_bound({next, 0});
  if (path == centre_.paths().end() || last == estimate.keyframes.begin()) return entry;
  --last;
  const auto node = path->node_of(last->first.seq);
  if (last->first.vehicle != frame.vehicle || !node) return entry;
  const fleet::Increment& reported = *path->nodes()[*node].step;
  entry.from = Entry::Keyframe{reported.T_odom_body, last->second.T_map_body, reported.covariance,
                               last->second.covariance};
  entry.T_map_local = last->second.T_map_body * reported.T_odom_body.inverse();
  return entry;
}

/// Each table levels the map by the current gravity estimate, which rotates all poses about the
/// first one. Without gravity the map keeps the orientation of the first pose.
Mat6 LiveMap::of_level(const SE3& T_map_body, double level_rad) const {
  if (levelled_ == 0) return Mat6::Zero();
  Eigen::Matrix<double, 6, 2> J;
  J.topRows<3>() = T_map_body.R.transpose().leftCols<2>();
  J.bottomRows<3>() = -geometry::skew(T_map_body.p).leftCols<2>();
  return level_rad * level_rad * J * J.transpose();
}

std::optional<LivePose> LiveMap::pose(const vehicle::PoseEstimate& pose) const {
  if (pose.vehicle.value >= members_.size()) return std::nullopt;
  const std::optional<Entry>& entry = members_[pose.vehicle.value].entry;
  if (!entry) return std::nullopt;
  // The vehicle has its gravity estimate a little earlier than the table.
  const bool unlevelled = pose.seeks_gravity || (pose.level_sigma_rad > 0.0 && levelled_ == 0);
  if (unlevelled && begin_ && (pose.t - *begin_).s() < kWaitLevel_s) return std::nullopt;
  LivePose live;
  live.t = pose.t;
  live.T_map_body = entry->T_map_local * pose.T_local_body;
  const geometry::Mat3& R = entry->T_map_local.R;
  const double alone_rad = fleet::level_sigma_rad(pose.level_sigma_rad, joint_);
  const Mat6 level =
      of_level(live.T_map_body, level_sigma_rad_ > 0.0 ? level_sigma_rad_ : alone_rad);
  live.covariance = turned(R, pose.covariance) + level;
  if (!entry->from) return live;
  const Entry::Keyframe& from = *entry->from;
  // Growth of the odometry's covariance since, added to the keyframe's covariance in the table.
  const Mat6 J_local = carried_by(from.T_local_body, pose.T_local_body);
  const Mat6 gathered =
      positive(pose.covariance - J_local * from.covariance_local * J_local.transpose());
  const Mat6 J_map = carried_by(from.T_map_body, live.T_map_body);
  live.covariance = J_map * from.covariance_map * J_map.transpose() + turned(R, gathered) + level;
  if (const auto moved = contradiction(pose, live)) {
    live.covariance += *moved * moved->transpose();
    live.contradicted = true;
  }
  return live;
}

/// A range after a long stretch without any corrects the error that the filter has accumulated. The
/// keyframe from which a live pose continues may still contain that error in the table, or not.
std::optional<geometry::Vec6> LiveMap::contradiction(const vehicle::PoseEstimate& pose,
                                                     const LivePose& live) const {
  constexpr double kSigmas = 3.0;
  const auto& T_map_odom = members_[pose.vehicle.value].T_map_odom_table;
  if (!T_map_odom) return std::nullopt;
  const SE3 T_without = *T_map_odom * pose.T_odom_body;
  geometry::Vec6 moved;
  moved << geometry::so3_log(live.T_map_body.R.transpose() * T_without.R),
      T_without.p - live.T_map_body.p;
  const Vec3 shift_m = moved.tail<3>();
  const double variance_m2 = shift_m.dot(live.covariance.bottomRightCorner<3, 3>() * shift_m) /
                             std::max(1e-12, shift_m.squaredNorm());
  const bool beyond = shift_m.squaredNorm() > kSigmas * kSigmas * variance_m2;
  return beyond && shift_m.norm() > kContradiction_m ? std::optional(moved) : std::nullopt;
}

std::optional<FrameStep> LiveMap::step(const vehicle::PoseEstimate& pose, const LivePose& live) {
  Member& member = members_[pose.vehicle.value];
  const SE3 T_map_odom = live.T_map_body * pose.T_odom_body.inverse();
  const bool new_table = member.tables != std::exchange(member.tables_seen, member.tables);
  const auto before = std::exchange(member.T_map_odom, T_map_odom);
  if (!member.T_map_odom_table) member.T_map_odom_table = T_map_odom;
  if (live.contradicted && due_) due_ = std::min(*due_, t_table_ + Duration::from_s(kFirst_s));
  FrameStep step;
  step.t = pose.t;
  if (!before) {
    step.reason = "joined";
    return step;
  }
  const SE3 T_was = *before * pose.T_odom_body;
  step.shift_m = (live.T_map_body.p - T_was.p).norm();
  step.turn_rad = geometry::so3_log(T_was.R.transpose() * live.T_map_body.R).norm();
  if (step.shift_m < kStep_m && step.turn_rad < kStep_rad) return std::nullopt;
  step.reason = new_table ? "table" : pose.range_from ? "range" : "lidar";
  return step;
}

}  // namespace rali::drive
