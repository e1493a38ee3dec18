#include "rali/drive/fact_path.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>

#include "rali/fleet/path/shape.hpp"

namespace rali::drive {
namespace {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// A node of a vehicle's path, with its start.
struct Node {
  Time t;
  std::uint32_t epoch = 0;
  const fleet::Increment* step = nullptr;
};

/// True if no node is missing between two nodes, and both are in one map.
bool is_next(const Node& a, const Node& b) {
  return a.epoch == b.epoch && !b.step->begins && b.step->node == a.step->node + 1;
}

std::vector<Node> nodes_of(const FleetFacts::Member& member) {
  std::vector<Node> nodes;
  for (const fleet::FactPtr& fact : member.facts) {
    const auto* step = std::get_if<fleet::Increment>(&fact->body);
    if (step != nullptr) nodes.push_back({fact->t, fact->key.epoch, step});
  }
  std::stable_sort(nodes.begin(), nodes.end(),
                   [](const Node& a, const Node& b) { return a.t < b.t; });
  return nodes;
}

/// The finest points of each keyframe.
std::map<std::uint32_t, const fleet::KeyframePoints*> points_of(const FleetFacts::Member& member) {
  std::map<std::uint32_t, const fleet::KeyframePoints*> points;
  for (const fleet::FactPtr& fact : member.facts) {
    const auto* seen = std::get_if<fleet::KeyframePoints>(&fact->body);
    if (seen == nullptr) continue;
    const fleet::KeyframePoints*& best = points[seen->keyframe];
    if (best == nullptr || (seen->refinement && !best->refinement)) best = seen;
  }
  return points;
}

/// When the vehicle measured a range that it considered valid, and to which peer; by time.
std::vector<std::pair<Time, VehicleId>> ranges_of(const FleetFacts::Member& member, VehicleId id) {
  std::vector<std::pair<Time, VehicleId>> ranges;
  for (const fleet::FactPtr& fact : member.facts) {
    const auto* block = std::get_if<fleet::RangeBlock>(&fact->body);
    if (block == nullptr) continue;
    for (const fleet::RangeEntry& range : block->ranges) {
      ranges.emplace_back(range.t, range.from == id ? range.to : range.from);
    }
  }
  std::sort(ranges.begin(), ranges.end());
  return ranges;
}

/// The direction that the LiDAR constrains least at a degenerate node, in odom.
Vec3 least_known_odom(const fleet::Increment& step) {
  const Eigen::SelfAdjointEigenSolver<geometry::Mat3> eigen(
      geometry::Mat3(step.lidar_information.bottomRightCorner<3, 3>()));
  return eigen.info() == Eigen::Success ? Vec3(eigen.eigenvectors().col(0)) : Vec3::Zero();
}

/// Follows a path and reproduces the outputs of the vehicle's software.
class PathFiller {
 public:
  PathFiller(const FleetFacts::Member& member, VehicleId id, const StartFrames& frames)
      : id_(id), frames_(frames), points_(points_of(member)), ranges_(ranges_of(member, id)) {
    for (const auto& [keyframe, points] : points_) {
      if (T_body_lidar_) break;
      T_body_lidar_ = points->T_body_lidar;
    }
  }

  /// Empty for a node of a start that is left out.
  vehicle::OutputList outputs_of(const Node& node) {
    vehicle::OutputList out;
    const auto frame = frames_.find(node.epoch);
    if (frame == frames_.end()) return out;
    const vehicle::PoseEstimate pose = pose_of(node, frame->second);
    if (node.step->keyframe) out.emplace_back(keyframe_of(node, pose));
    out.insert(out.begin(), pose);
    if (node.step->levelled) {
      gravity_ = vehicle::GravityEstimate{id_, node.t, frame->second.R * node.step->g_odom_mps2,
                                          geometry::Mat3::Constant(kUnknown)};
    }
    return out;
  }

  /// The last known gravity; a fact does not contain its covariance.
  [[nodiscard]] const std::optional<vehicle::GravityEstimate>& gravity() const { return gravity_; }

 private:
  vehicle::PoseEstimate pose_of(const Node& node, const SE3& T_local_odom) {
    const fleet::Increment& step = *node.step;
    vehicle::PoseEstimate pose;
    pose.vehicle = id_;
    pose.t = node.t;
    pose.T_local_body = pose.T_odom_body = T_local_odom * step.T_odom_body;
    pose.v_odom_mps = T_local_odom.R * step.v_odom_mps;
    // Rotation is perturbed in the body, position in the outer frame: only the latter turns.
    Mat6 turn = Mat6::Identity();
    turn.bottomRightCorner<3, 3>() = T_local_odom.R;
    pose.covariance = turn * step.covariance * turn.transpose();
    pose.at_rest = step.at_rest;
    pose.degeneracy.degenerate = step.degenerate;
    pose.degeneracy.sigma_degenerate_m = kUnknown;
    if (step.degenerate) pose.degeneracy.degenerate_odom = T_local_odom.R * least_known_odom(step);
    for (; next_range_ < ranges_.size() && ranges_[next_range_].first <= node.t; ++next_range_) {
      pose.range_from = ranges_[next_range_].second;
    }
    return pose;
  }

  vehicle::KeyframeAdded keyframe_of(const Node& node, const vehicle::PoseEstimate& pose) {
    auto keyframe = std::make_shared<odometry::Keyframe>();
    keyframe->t = node.t;
    keyframe->T_odom_body = pose.T_local_body;
    keyframe->covariance = pose.covariance;
    if (before_ && epoch_before_ == node.epoch && !node.step->begins) {
      keyframe->T_previous_this = before_->T_odom_body.inverse() * keyframe->T_odom_body;
      fleet::tie_by_filter(keyframe->information_relative, before_->covariance,
                           keyframe->covariance, {1e-3, 0.01});
    }
    keyframe->T_body_lidar = T_body_lidar_.value_or(SE3{});
    if (const auto seen = points_.find(*node.step->keyframe); seen != points_.end()) {
      T_body_lidar_ = keyframe->T_body_lidar = seen->second->T_body_lidar;
      fleet::PointArrays points = seen->second->points.unpacked();
      keyframe->cloud.intensity.assign(points.intensity.begin(), points.intensity.end());
      keyframe->cloud.x_m = std::move(points.x_m);
      keyframe->cloud.y_m = std::move(points.y_m);
      keyframe->cloud.z_m = std::move(points.z_m);
    }
    keyframe->cloud.intensity.resize(keyframe->cloud.size());
    before_ = keyframe;
    epoch_before_ = node.epoch;
    return {{id_, *node.step->keyframe}, keyframe};
  }

  VehicleId id_;
  const StartFrames& frames_;
  std::map<std::uint32_t, const fleet::KeyframePoints*> points_;
  std::vector<std::pair<Time, VehicleId>> ranges_;
  std::size_t next_range_ = 0;
  std::optional<SE3> T_body_lidar_;
  std::shared_ptr<const odometry::Keyframe> before_;
  std::uint32_t epoch_before_ = 0;
  std::optional<vehicle::GravityEstimate> gravity_;
};

/// The input report of a vehicle that is given by facts.
class FactPathSource final : public ReportedSource {
 public:
  explicit FactPathSource(InputReport report) : report_(std::move(report)) {}

  [[nodiscard]] const InputReport& report() const override { return report_; }

  [[nodiscard]] Result<std::optional<vehicle::Event>> next() override {
    return std::optional<vehicle::Event>();
  }

  [[nodiscard]] double progress() const override { return 1.0; }

 private:
  InputReport report_;
};

}  // namespace

std::unique_ptr<ReportedSource> fact_source(const FleetFacts& facts, std::size_t member) {
  const FleetFacts::Member& author = facts.members[member];
  InputReport report;
  report.vehicle = author.name;
  report.files = facts.folders;
  report.T_body_lidar_origin = "the vehicle's facts";
  const std::vector<Node> nodes = nodes_of(author);
  report.scans = nodes.size();
  if (!nodes.empty()) {
    report.t_start = nodes.front().t;
    report.t_end = nodes.back().t;
  }
  report.has_imu =
      std::any_of(nodes.begin(), nodes.end(), [](const Node& node) { return node.step->levelled; });
  if (const auto points = points_of(author); !points.empty()) {
    report.T_body_lidar = points.begin()->second->T_body_lidar;
  }
  for (const Node& node : nodes) {
    if (node.step->inertial) report.T_body_imu = node.step->inertial->T_body_imu;
  }
  report.gaps.damaged = author.missing > 0;
  return std::make_unique<FactPathSource>(std::move(report));
}

Status fill_from_facts(const FleetFacts& facts, VehicleId id, const StartFrames& frames,
                       VehicleRun& run) {
  const FleetFacts::Member& member = facts.members[id.value];
  FindingList none;
  for (const fleet::FactPtr& fact : member.facts) {
    if (Status s = run.take({vehicle::FactMade{fact}}, none); !s) return s;
  }
  PathFiller filler(member, id, frames);
  const Node* before = nullptr;
  const std::vector<Node> nodes = nodes_of(member);
  for (const Node& node : nodes) {
    const vehicle::OutputList outputs = filler.outputs_of(node);
    if (outputs.empty()) continue;
    if (Status s = run.take(outputs, none); !s) return s;
    if (before != nullptr && is_next(*before, node)) run.tie_last_pose();
    before = &node;
  }
  return filler.gravity() ? run.take({*filler.gravity()}, none) : Status{};
}

}  // namespace rali::drive
