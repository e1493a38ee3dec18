#include "rali/fleet/node/survey.hpp"

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

map::KeyframeView view_of(VehicleId vehicle, Time t, const SE3& T_map_body,
                          const KeyframePoints& points) {
  map::KeyframeView view;
  view.t = t;
  view.vehicle = static_cast<std::uint8_t>(vehicle.value);
  view.T_map_body = T_map_body;
  view.T_body_lidar = points.T_body_lidar;
  view.x_m = points.x_m;
  view.y_m = points.y_m;
  view.z_m = points.z_m;
  return view;
}

/// The horizontal direction that a blind node's LiDAR tells least about, in odom.
std::optional<Vec2> blind_axis_odom(const Increment& step) {
  if (!step.blind) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(
      step.lidar_information.block<2, 2>(3, 3));
  if (eigen.info() != Eigen::Success) return std::nullopt;
  return Vec2(eigen.eigenvectors().col(0));
}

/// In few numbers; boxplus order.
PoseSigma sigma_of(const geometry::Mat6& P) {
  PoseSigma sigma;
  const auto root = [](double variance) { return std::sqrt(std::max(0.0, variance)); };
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(P.block<2, 2>(3, 3));
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

Survey::Survey(const NodeSettings& settings, const FleetKnowledge& known)
    : settings_(settings),
      known_(known),
      centre_(std::make_unique<RoundCentre>(settings.fleet, known)),
      grid_(settings.explore) {}

void Survey::add(const FactPtr& fact) {
  waiting_.push_back(fact);
  if (const auto* step = std::get_if<Increment>(&fact->body)) {
    Increment light = *step;
    light.inertial.reset();
    paths_.add(fact->key, fact->t, light);
  } else if (const auto* points = std::get_if<KeyframePoints>(&fact->body)) {
    points_[{fact->key.vehicle, fact->key.epoch}].emplace(points->keyframe, fact);
  } else if (std::holds_alternative<EpochStart>(fact->body)) {
    paths_.add(fact->key, fact->t, fact->body);
  }
}

const VehiclePath* Survey::last_path_of(VehicleId vehicle) const {
  const VehiclePath* found = nullptr;
  for (const VehiclePath& path : paths_.all()) {
    if (path.vehicle() == vehicle && !path.nodes().empty()) found = &path;  // the last epoch
  }
  return found;
}

const VehiclePath* Survey::first_path_of(VehicleId vehicle) const {
  for (const VehiclePath& path : paths_.all()) {
    if (path.vehicle() == vehicle && !path.nodes().empty()) return &path;
  }
  return nullptr;
}

/// A vehicle's keyframes have numbers of their own in each epoch (keyframe_number.hpp).
const VehiclePath* Survey::path_with(KeyframeId keyframe) const {
  for (const VehiclePath& path : paths_.all()) {
    if (path.vehicle() == keyframe.vehicle && path.node_of(keyframe.seq)) return &path;
  }
  return nullptr;
}

bool Survey::is_placed(const VehiclePath& path) const {
  return T_map_odom_.contains(stream_of(path));
}

bool Survey::is_placed(VehicleId vehicle) const {
  const VehiclePath* path = last_path_of(vehicle);
  return path != nullptr && is_placed(*path);
}

std::shared_ptr<Job> Survey::make_job(std::optional<Time> end_round) {
  RALI_ASSERT(centre_ != nullptr);
  auto job = std::make_shared<SurveyJob>();
  job->centre_ = std::move(centre_);
  job->facts_ = std::exchange(waiting_, {});
  job->legacy_ = std::exchange(legacy_, std::nullopt);
  job->end_round_ = end_round;
  job->generation_ = generation_;
  return job;
}

Survey::Back Survey::take_back(Job* job, bool wanted) {
  auto* back = dynamic_cast<SurveyJob*>(job);
  if (back == nullptr || back->centre_ == nullptr) return Back::kLost;
  centre_ = std::move(back->centre_);
  work_ = centre_->work();
  // Of one that never ran.
  waiting_.insert(waiting_.begin(), back->facts_.begin(), back->facts_.end());
  if (!legacy_) legacy_ = std::move(back->legacy_);
  if (!wanted || !back->solved_ || back->generation_ != generation_) return Back::kDropped;
  boundary_ = centre_->boundary();
  take(std::move(back->estimate_));
  if (back->end_round_) {
    static_cast<void>(refresh());
    forget_drawn_points();
  }
  return Back::kTaken;
}

void Survey::restore(std::vector<FactPtr> facts) {
  centre_ = std::make_unique<RoundCentre>(settings_.fleet, known_);
  waiting_ = std::move(facts);
}

/// The grid keeps outlines of its own. While vehicles may still be taken out of the map and come
/// back, they are needed again.
void Survey::forget_drawn_points() {
  if (!boundary_) return;
  for (auto& [stream, points] : points_) {
    std::erase_if(points, [&](const auto& entry) {
      return in_grid_.contains({stream.vehicle, entry.first});
    });
  }
}

bool Survey::take_over(const RoundBoundary& boundary,
                       const std::map<KeyframeId, KeyframePose>& keyframes) {
  auto done = finished_before(boundary, paths_.all(), keyframes, settings_.fleet);
  if (!done) return false;
  ++generation_;
  legacy_ = Legacy{boundary, keyframes};
  boundary_ = boundary;
  for (const auto& [id, pose] : keyframes) told_[id] = pose.T_map_body;
  take(std::move(*done));
  return true;
}

void Survey::take(FleetEstimate estimate) {
  last_ = std::move(estimate);
  find_frames();
  for (auto it = in_grid_.begin(); it != in_grid_.end();) {
    const KeyframeId id = it->first;
    const VehiclePath* path = path_with(id);
    if (path == nullptr || !is_placed(*path)) {
      grid_.remove(id);
      it = in_grid_.erase(it);
      continue;
    }
    it->second = pose_of(*path, *path->node_of(id.seq));
    grid_.move(id, it->second);
    ++it;
  }
  list_seen();
}

/// How each odom lies at the vehicle's newest keyframe that the estimate knows.
void Survey::find_frames() {
  T_map_odom_.clear();
  for (const VehicleFrame& frame : last_.frames) {
    if (frame.group != 0) continue;
    SE3 T = frame.T_map_odom;
    const StreamKey stream{frame.vehicle, frame.epoch};
    const VehiclePath* path = path_of(paths_.all(), stream);
    if (path == nullptr || path->nodes().empty()) continue;
    const std::uint32_t last = first_keyframe_of(frame.epoch) + (kKeyframesPerEpoch - 1);
    const auto after = last_.keyframes.upper_bound({frame.vehicle, last});
    if (after != last_.keyframes.begin()) {
      const auto& [id, pose] = *std::prev(after);
      const auto node = id.vehicle == frame.vehicle ? path->node_of(id.seq) : std::nullopt;
      if (node) T = pose.T_map_body * path->nodes()[*node].step.T_odom_body.inverse();
    }
    T_map_odom_[stream] = T;
  }
}

SE3 Survey::pose_of(const VehiclePath& path, std::size_t node) const {
  const Increment& step = path.nodes()[node].step;
  if (step.keyframe) {
    const auto known = last_.keyframes.find({path.vehicle(), *step.keyframe});
    if (known != last_.keyframes.end()) return known->second.T_map_body;
  }
  return T_map_odom_.at(stream_of(path)) * step.T_odom_body;
}

std::size_t Survey::refresh() {
  std::size_t added = 0;
  for (const VehiclePath& path : paths_.all()) {
    if (!is_placed(path)) continue;
    const auto points_of = points_.find(stream_of(path));
    if (points_of == points_.end()) continue;
    for (const auto& [number, fact] : points_of->second) {
      const KeyframeId id{path.vehicle(), number};
      const auto& points = std::get<KeyframePoints>(fact->body);
      const auto node = path.node_of(number);
      if (!node || in_grid_.contains(id)) continue;
      const SE3 T = pose_of(path, *node);
      if (!grid_.add(id, view_of(path.vehicle(), path.nodes()[*node].t, T, points))) continue;
      in_grid_[id] = T;
      ++added;
    }
  }
  list_seen();
  return added;
}

void Survey::list_seen() {
  seen_.clear();
  for (const VehiclePath& path : paths_.all()) {
    if (!is_placed(path)) continue;
    for (std::size_t k = 0; k < path.nodes().size(); ++k) {
      const SE3 T = pose_of(path, k);
      Seen seen{T.p.head<2>(), T.p.z(), {}};
      if (const auto axis = blind_axis_odom(path.nodes()[k].step)) {
        const Vec3 in_map = T_map_odom_.at(stream_of(path)).R * Vec3(axis->x(), axis->y(), 0.0);
        seen.blind_axis = in_map.head<2>().normalized();
      }
      seen_.push_back(seen);
    }
  }
}

/// Where a vehicle was measured is where its first epoch began.
std::optional<SE3> Survey::measured(const StreamKey& stream) const {
  const VehicleId vehicle = stream.vehicle;
  const VehiclePath* path = first_path_of(vehicle);
  if (path == nullptr || stream_of(*path) != stream) return std::nullopt;
  for (const GivenStart& start : known_.starts) {
    const bool forward = start.vehicle == vehicle;
    if (!forward && start.relative_to != vehicle) continue;
    const VehicleId other = forward ? start.relative_to : start.vehicle;
    const VehiclePath* base = first_path_of(other);
    if (base == nullptr) continue;
    const auto placed = T_map_odom_.find(stream_of(*base));
    if (placed == T_map_odom_.end()) continue;
    const SE3 T_map_level = placed->second * T_map_odom_alone(*base).inverse();
    const SE3 T_other_self =
        forward ? start.T_relative_vehicle : start.T_relative_vehicle.inverse();
    return T_map_level * T_other_self * T_map_odom_alone(*path);
  }
  return std::nullopt;
}

std::optional<SE3> Survey::T_map_odom(const StreamKey& stream) const {
  const auto placed = T_map_odom_.find(stream);
  return placed != T_map_odom_.end() ? std::optional(placed->second) : measured(stream);
}

BlindAxisAt Survey::blind_axis() const {
  // A copy: the axes outlive the next keyframe.
  const auto seen = std::make_shared<const std::vector<Seen>>(seen_);
  return [seen](const Vec2& place_map_m) -> std::optional<Vec2> {
    const Seen* nearest = nullptr;
    double best = std::numeric_limits<double>::infinity();
    for (const Seen& s : *seen) {
      const double d = (s.p_map_m - place_map_m).squaredNorm();
      if (d < best) {
        best = d;
        nearest = &s;
      }
    }
    return nearest != nullptr ? nearest->blind_axis : std::nullopt;
  };
}

double Survey::height_m(const Vec2& place_map_m) const {
  double best = std::numeric_limits<double>::infinity(), z_m = 0.0;
  for (const Seen& s : seen_) {
    const double d = (s.p_map_m - place_map_m).squaredNorm();
    if (d < best) {
      best = d;
      z_m = s.z_m;
    }
  }
  return z_m;
}

std::size_t Survey::new_places_since(Time t) const {
  std::vector<Vec3> before, since;
  for (const VehiclePath& path : paths_.all()) {
    if (!is_placed(path)) continue;
    for (std::size_t k = 0; k < path.nodes().size(); ++k) {
      const VehiclePath::Node& node = path.nodes()[k];
      if (node.step.keyframe) (node.t < t ? before : since).push_back(pose_of(path, k).p);
    }
  }
  const auto is_new = [&](const Vec3& p) {
    return std::none_of(before.begin(), before.end(),
                        [&](const Vec3& q) { return (p - q).norm() <= settings_.place_m; });
  };
  return static_cast<std::size_t>(std::count_if(since.begin(), since.end(), is_new));
}

std::vector<Table> Survey::tables(std::uint64_t term, std::uint32_t revision, double moved_m) {
  std::map<KeyframeId, SE3> all = in_grid_;
  for (const auto& [id, pose] : last_.keyframes) {
    const VehiclePath* path = path_with(id);
    if (path != nullptr && is_placed(*path)) all[id] = pose.T_map_body;
  }
  std::vector<TablePose> moved;
  std::uint64_t hash = 14695981039346656037ULL;
  for (const auto& [id, T] : all) {
    hash = mixed(hash, (std::uint64_t{id.vehicle.value} << 32) | id.seq);
    for (int axis = 0; axis < 3; ++axis) {
      hash = mixed(hash, static_cast<std::uint64_t>(std::llround(T.p[axis] * 1e4)));
    }
    const auto before = told_.find(id);
    const bool same = before != told_.end() && (before->second.p - T.p).norm() <= moved_m;
    if (same) continue;
    told_[id] = T;
    const auto known = last_.keyframes.find(id);
    const PoseSigma sigma =
        known == last_.keyframes.end() ? PoseSigma{} : sigma_of(known->second.covariance);
    moved.push_back({stream_of(*path_with(id)), id.seq, T, sigma});
  }
  Table table;
  table.term = term;
  table.revision = revision;
  table.base_revision = revision > 0 ? revision - 1 : 0;
  table.hash = hash;
  std::uint16_t group = std::numeric_limits<std::uint16_t>::max();
  for (const auto& [stream, T] : T_map_odom_) group = std::min(group, stream.vehicle.value);
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
