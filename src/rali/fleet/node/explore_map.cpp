#include "rali/fleet/node/explore_map.hpp"

#include <algorithm>
#include <limits>

#include <Eigen/Eigenvalues>

namespace rali::fleet {

using geometry::SE3;
using geometry::Vec2;
using geometry::Vec3;

namespace {

map::KeyframeView view_of(VehicleId vehicle, Time t, const SE3& T_map_body, const SE3& T_body_lidar,
                          const PointArrays& points) {
  map::KeyframeView view;
  view.t = t;
  view.vehicle = static_cast<std::uint8_t>(vehicle.value);
  view.T_map_body = T_map_body;
  view.T_body_lidar = T_body_lidar;
  view.x_m = points.x_m;
  view.y_m = points.y_m;
  view.z_m = points.z_m;
  return view;
}

/// The horizontal direction with the least LiDAR information at a degenerate node, in odom.
std::optional<Vec2> degenerate_axis_odom(const Increment& step) {
  if (!step.degenerate) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(
      Eigen::Matrix2d(step.lidar_information.block<2, 2>(3, 3)));
  if (eigen.info() != Eigen::Success) return std::nullopt;
  return Vec2(eigen.eigenvectors().col(0));
}

}  // namespace

void ExploreMap::add(const FactPtr& fact) {
  const VehicleId vehicle = fact->key.vehicle;
  const StreamKey stream{vehicle, fact->key.epoch};
  if (const auto* step = std::get_if<Increment>(&fact->body)) {
    const Node node{stream, fact->t, step->T_odom_body, step->keyframe,
                    degenerate_axis_odom(*step)};
    const auto [added, is_new] = nodes_[stream].try_emplace(step->node, node);
    if (is_new && step->keyframe) node_of_[{vehicle, *step->keyframe}] = &added->second;
  } else if (const auto* points = std::get_if<KeyframePoints>(&fact->body)) {
    points_.emplace(KeyframeId{vehicle, points->keyframe}, fact);
  }
}

const ExploreMap::Node* ExploreMap::node_of(KeyframeId keyframe) const {
  const auto found = node_of_.find(keyframe);
  return found != node_of_.end() ? found->second : nullptr;
}

bool ExploreMap::draw(const Placement& placed, StopFlag stop) {
  list_seen(placed);
  return move_drawn(placed, stop) && draw_new(placed, stop);
}

bool ExploreMap::move_drawn(const Placement& placed, StopFlag stop) {
  for (auto it = drawn_.begin(); it != drawn_.end();) {
    if (stop.raised()) return false;
    const KeyframeId id = *it;
    const Node* node = node_of(id);
    if (node == nullptr || !placed.holds(node->stream)) {
      grid_.remove(id);
      it = drawn_.erase(it);
      continue;
    }
    grid_.move(id, placed.T_map_body(node->stream, node->keyframe, node->T_odom_body));
    ++it;
  }
  return true;
}

bool ExploreMap::draw_new(const Placement& placed, StopFlag stop) {
  for (const auto& [id, fact] : points_) {
    if (stop.raised()) return false;
    const Node* node = node_of(id);
    if (node == nullptr || drawn_.contains(id) || !placed.holds(node->stream)) continue;
    const SE3 T = placed.T_map_body(node->stream, node->keyframe, node->T_odom_body);
    const auto& seen = std::get<KeyframePoints>(fact->body);
    const PointArrays points = seen.points.unpacked();
    if (grid_.add(id, view_of(id.vehicle, node->t, T, seen.T_body_lidar, points))) {
      drawn_.insert(id);
    }
  }
  return true;
}

void ExploreMap::forget_drawn_points() {
  std::erase_if(points_, [this](const auto& entry) { return drawn_.contains(entry.first); });
}

void ExploreMap::list_seen(const Placement& placed) {
  seen_.clear();
  for (const auto& [stream, nodes] : nodes_) {
    const auto frame = placed.T_map_odom.find(stream);
    if (frame == placed.T_map_odom.end()) continue;
    for (const auto& [number, node] : nodes) {
      const SE3 T = placed.T_map_body(stream, node.keyframe, node.T_odom_body);
      Seen seen{node.t, T.p, node.keyframe.has_value(), {}};
      if (const auto& axis = node.degenerate_axis_odom) {
        const Vec3 in_map = frame->second.R * Vec3(axis->x(), axis->y(), 0.0);
        seen.degenerate_axis = in_map.head<2>().normalized();
      }
      seen_.push_back(seen);
    }
  }
}

const ExploreMap::Seen* ExploreMap::nearest(const Vec2& place_map_m) const {
  const Seen* nearest = nullptr;
  double best = std::numeric_limits<double>::infinity();
  for (const Seen& s : seen_) {
    const double d = (s.p_map_m.head<2>() - place_map_m).squaredNorm();
    if (d < best) {
      best = d;
      nearest = &s;
    }
  }
  return nearest;
}

DegenerateAxisAt ExploreMap::degenerate_axis() const {
  return [this](const Vec2& place_map_m) -> std::optional<Vec2> {
    const Seen* seen = nearest(place_map_m);
    return seen != nullptr ? seen->degenerate_axis : std::nullopt;
  };
}

double ExploreMap::height_m(const Vec2& place_map_m) const {
  const Seen* seen = nearest(place_map_m);
  return seen != nullptr ? seen->p_map_m.z() : 0.0;
}

std::size_t ExploreMap::new_places_since(Time t, double apart_m) const {
  std::vector<Vec3> before, since;
  for (const Seen& seen : seen_) {
    if (seen.keyframe) (seen.t < t ? before : since).push_back(seen.p_map_m);
  }
  const auto is_new = [&](const Vec3& p) {
    return std::none_of(before.begin(), before.end(),
                        [&](const Vec3& q) { return (p - q).norm() <= apart_m; });
  };
  return static_cast<std::size_t>(std::count_if(since.begin(), since.end(), is_new));
}

}  // namespace rali::fleet
