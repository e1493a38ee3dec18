#include "rali/fleet/node/fleet_mapper.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>

#include "rali/base/assert.hpp"
#include "rali/fleet/centre/path_frames.hpp"
#include "rali/fleet/facts/keyframe_number.hpp"

namespace rali::fleet {

using geometry::SE3;
using geometry::Vec2;
using geometry::Vec3;

namespace {

constexpr std::size_t kPosesPerPart = 500;

/// In few numbers, from a covariance in boxplus order.
PoseSigma sigma_of(const geometry::Mat6& P) {
  PoseSigma sigma;
  const auto root = [](double variance) { return std::sqrt(std::max(0.0, variance)); };
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(Eigen::Matrix2d(P.block<2, 2>(3, 3)));
  if (eigen.info() != Eigen::Success) return sigma;
  sigma.minor_m = root(eigen.eigenvalues()[0]);
  sigma.major_m = root(eigen.eigenvalues()[1]);
  const Vec2 axis = eigen.eigenvectors().col(1);
  const double azimuth = std::atan2(axis.y(), axis.x());
  sigma.major_azimuth_rad = azimuth < 0.0 ? azimuth + std::numbers::pi : azimuth;
  sigma.z_m = root(P(5, 5));
  sigma.yaw_rad = root(P(2, 2));
  return sigma;
}

std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
  constexpr std::uint64_t kPrime = 1099511628211ULL;  // FNV-1a
  for (int byte = 0; byte < 8; ++byte) hash = (hash ^ ((value >> (8 * byte)) & 0xffU)) * kPrime;
  return hash;
}

}  // namespace

FleetMapper::FleetMapper(const NodeSettings& settings, const FleetKnowledge& known)
    : settings_(settings),
      known_(known),
      centre_(std::make_unique<RoundCentre>(settings.fleet, known)) {}

void FleetMapper::add(const FactPtr& fact) {
  waiting_.push_back(fact);
  const bool of_path = std::holds_alternative<Increment>(fact->body) ||
                       std::holds_alternative<EpochStart>(fact->body);
  if (of_path) paths_.add(fact);
}

const VehiclePath* FleetMapper::last_path_of(VehicleId vehicle) const {
  const VehiclePath* found = nullptr;
  for (const VehiclePath& path : paths_.all()) {
    if (path.vehicle() == vehicle && !path.nodes().empty()) found = &path;  // the last epoch
  }
  return found;
}

const VehiclePath* FleetMapper::first_path_of(VehicleId vehicle) const {
  for (const VehiclePath& path : paths_.all()) {
    if (path.vehicle() == vehicle && !path.nodes().empty()) return &path;
  }
  return nullptr;
}

/// The keyframe numbers of a vehicle differ between epochs (keyframe_number.hpp).
const VehiclePath* FleetMapper::path_with(KeyframeId keyframe) const {
  for (const VehiclePath& path : paths_.all()) {
    if (path.vehicle() == keyframe.vehicle && path.node_of(keyframe.seq)) return &path;
  }
  return nullptr;
}

bool FleetMapper::is_placed(const VehiclePath& path) const {
  return placed_->holds(stream_of(path));
}

bool FleetMapper::is_placed(VehicleId vehicle) const {
  const VehiclePath* path = last_path_of(vehicle);
  return path != nullptr && is_placed(*path);
}

std::shared_ptr<Job> FleetMapper::make_job(std::optional<Time> end_round) {
  RALI_ASSERT(centre_ != nullptr);
  auto job = std::make_shared<FleetMapperJob>();
  job->centre_ = std::move(centre_);
  job->facts_ = std::exchange(waiting_, {});
  job->legacy_ = std::exchange(legacy_, std::nullopt);
  job->end_round_ = end_round;
  job->generation_ = generation_;
  return job;
}

JobOutcome FleetMapper::take_back(Job* job, bool wanted) {
  auto* back = dynamic_cast<FleetMapperJob*>(job);
  if (back == nullptr || back->centre_ == nullptr) return JobOutcome::kLost;
  centre_ = std::move(back->centre_);
  work_ = centre_->work();
  // Facts of a job that never ran.
  waiting_.insert(waiting_.begin(), back->facts_.begin(), back->facts_.end());
  if (!legacy_) legacy_ = std::move(back->legacy_);
  if (!wanted || !back->solved_ || back->generation_ != generation_) return JobOutcome::kDropped;
  separator_ = centre_->separator();
  take(std::move(back->estimate_));
  return JobOutcome::kTaken;
}

void FleetMapper::restore(std::vector<FactPtr> facts) {
  centre_ = std::make_unique<RoundCentre>(settings_.fleet, known_);
  waiting_ = std::move(facts);
}

bool FleetMapper::take_over(const SeparatorPrior& separator,
                            const std::map<KeyframeId, KeyframePose>& keyframes) {
  auto done = finished_before(separator, paths_.all(), keyframes, settings_.fleet);
  if (!done) return false;
  ++generation_;
  legacy_ = Legacy{separator, keyframes};
  separator_ = separator;
  for (const auto& [id, pose] : keyframes) reported_[id] = pose.T_map_body;
  take(std::move(*done));
  return true;
}

/// The pose of each odom is that at the vehicle's newest keyframe in the estimate.
void FleetMapper::take(FleetEstimate estimate) {
  auto placed = std::make_shared<Placement>();
  placed->estimate = std::move(estimate);
  const std::map<KeyframeId, KeyframePose>& keyframes = placed->estimate.keyframes;
  for (const VehicleFrame& frame : placed->estimate.frames) {
    if (frame.group != 0) continue;
    SE3 T = frame.T_map_odom;
    const StreamKey stream{frame.vehicle, frame.epoch};
    const VehiclePath* path = path_of(paths_.all(), stream);
    if (path == nullptr || path->nodes().empty()) continue;
    const std::uint32_t last = first_keyframe_of(frame.epoch) + (kKeyframesPerEpoch - 1);
    const auto after = keyframes.upper_bound({frame.vehicle, last});
    if (after != keyframes.begin()) {
      const auto& [id, pose] = *std::prev(after);
      const auto node = id.vehicle == frame.vehicle ? path->node_of(id.seq) : std::nullopt;
      if (node) T = pose.T_map_body * path->nodes()[*node].step->T_odom_body.inverse();
    }
    placed->T_map_odom[stream] = T;
  }
  placed_ = std::move(placed);
}

/// A measured start pose of a vehicle is the start of its first epoch.
std::optional<SE3> FleetMapper::measured(const StreamKey& stream) const {
  const VehicleId vehicle = stream.vehicle;
  const VehiclePath* path = first_path_of(vehicle);
  if (path == nullptr || stream_of(*path) != stream) return std::nullopt;
  for (const GivenStart& start : known_.starts) {
    const bool forward = start.vehicle == vehicle;
    if (!forward && start.relative_to != vehicle) continue;
    const VehicleId other = forward ? start.relative_to : start.vehicle;
    const VehiclePath* base = first_path_of(other);
    if (base == nullptr) continue;
    const auto placed = placed_->T_map_odom.find(stream_of(*base));
    if (placed == placed_->T_map_odom.end()) continue;
    const SE3 T_map_level = placed->second * T_map_odom_alone(*base).inverse();
    const SE3 T_other_self =
        forward ? start.T_relative_vehicle : start.T_relative_vehicle.inverse();
    return T_map_level * T_other_self * T_map_odom_alone(*path);
  }
  return std::nullopt;
}

std::optional<SE3> FleetMapper::T_map_odom(const StreamKey& stream) const {
  const auto placed = placed_->T_map_odom.find(stream);
  return placed != placed_->T_map_odom.end() ? std::optional(placed->second) : measured(stream);
}

std::vector<Table> FleetMapper::tables(std::uint64_t term, std::uint32_t revision, double moved_m) {
  std::vector<TablePose> moved;
  std::uint64_t hash = 14695981039346656037ULL;
  for (const auto& [id, pose] : last().keyframes) {
    const VehiclePath* path = path_with(id);
    if (path == nullptr || !is_placed(*path)) continue;
    const SE3& T = pose.T_map_body;
    hash = mixed(hash, (std::uint64_t{id.vehicle.value} << 32) | id.seq);
    for (int axis = 0; axis < 3; ++axis) {
      hash = mixed(hash, static_cast<std::uint64_t>(std::llround(T.p[axis] * 1e4)));
    }
    const auto before = reported_.find(id);
    const bool same = before != reported_.end() && (before->second.p - T.p).norm() <= moved_m;
    if (same) continue;
    reported_[id] = T;
    moved.push_back({stream_of(*path), id.seq, T, sigma_of(pose.covariance)});
  }
  Table table;
  table.term = term;
  table.revision = revision;
  table.base_revision = revision > 0 ? revision - 1 : 0;
  table.hash = hash;
  std::uint16_t group = std::numeric_limits<std::uint16_t>::max();
  for (const auto& [stream, T] : placed_->T_map_odom) group = std::min(group, stream.vehicle.value);
  for (const VehiclePath& path : paths_.all()) {
    const auto T = T_map_odom(stream_of(path));
    if (T) table.frames.push_back({stream_of(path), group, *T, {}});
  }
  std::vector<Table> parts;
  std::size_t next = 0;
  do {
    const std::size_t end = std::min(moved.size(), next + kPosesPerPart);
    table.poses.assign(moved.begin() + static_cast<std::ptrdiff_t>(next),
                       moved.begin() + static_cast<std::ptrdiff_t>(end));
    table.part = static_cast<std::uint16_t>(parts.size());
    table.last_part = end == moved.size();
    parts.push_back(table);
    next = end;
  } while (next < moved.size());
  return parts;
}

}  // namespace rali::fleet
