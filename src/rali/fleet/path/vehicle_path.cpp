#include "rali/fleet/path/vehicle_path.hpp"

#include <algorithm>
#include <utility>

#include "rali/geometry/so3.hpp"

namespace rali::fleet {

using geometry::SE3;
using geometry::Vec3;

namespace {

/// The pose at a fraction of the step from a to b, on the arc of constant twist. The left Jacobian
/// of a rotation is the right one of the inverse rotation.
SE3 on_arc(const SE3& a, const SE3& b, double fraction) {
  const SE3 step = a.inverse() * b;
  const Vec3 turn = geometry::so3_log(step.R);
  const Vec3 speed = geometry::so3_right_jacobian_inverse(-turn) * step.p;
  SE3 part;
  part.R = geometry::so3_exp(fraction * turn);
  part.p = geometry::so3_right_jacobian(-fraction * turn) * (fraction * speed);
  return a * part;
}

}  // namespace

/// The pointers into the fact own it.
void VehiclePath::add(const FactPtr& fact) {
  const FactBody& body = fact->body;
  if (const auto* start = std::get_if<EpochStart>(&body)) start_ = *start;
  if (const auto* step = std::get_if<Increment>(&body)) add_node(fact->t, {fact, step});
  if (const auto* block = std::get_if<RangeBlock>(&body)) {
    for (const RangeEntry& range : block->ranges) add_range({fact, &range});
  }
  if (const auto* points = std::get_if<KeyframePoints>(&body)) {
    points_.emplace(points->keyframe, *points);
  }
}

void VehiclePath::add(Time t, FactBody body) {
  add(std::make_shared<const Fact>(Fact{{vehicle_, epoch_, 0}, t, std::move(body)}));
}

void VehiclePath::add_node(Time t, std::shared_ptr<const Increment> step) {
  const auto place = numbered(step->node);
  if (place != nodes_.end() && place->step->node == step->node) return;
  if (step->keyframe) keyframes_[*step->keyframe] = step->node;
  nodes_.insert(place, {t, std::move(step)});
}

void VehiclePath::add_range(std::shared_ptr<const RangeEntry> range) {
  const auto place = std::upper_bound(ranges_.begin(), ranges_.end(), range->t,
                                      [](Time t, const auto& entry) { return t < entry->t; });
  ranges_.insert(place, std::move(range));
}

std::optional<std::size_t> VehiclePath::node_of(std::uint32_t keyframe) const {
  const auto found = keyframes_.find(keyframe);
  if (found == keyframes_.end()) return std::nullopt;
  return static_cast<std::size_t>(numbered(found->second) - nodes_.begin());
}

std::optional<std::size_t> VehiclePath::index_of(std::uint32_t number) const {
  const auto found = numbered(number);
  if (found == nodes_.end() || found->step->node != number) return std::nullopt;
  return static_cast<std::size_t>(found - nodes_.begin());
}

std::vector<VehiclePath::Node>::const_iterator VehiclePath::numbered(std::uint32_t number) const {
  return std::lower_bound(nodes_.begin(), nodes_.end(), number,
                          [](const Node& node, std::uint32_t n) { return node.step->node < n; });
}

bool VehiclePath::ties_to_before(std::size_t k) const {
  if (k == 0 || nodes_[k].step->begins) return false;
  return nodes_[k].step->node == nodes_[k - 1].step->node + 1;
}

std::optional<PathPlace> VehiclePath::at(Time t) const {
  if (nodes_.empty() || t < nodes_.front().t || t > nodes_.back().t) return std::nullopt;
  const auto after = std::upper_bound(nodes_.begin(), nodes_.end(), t,
                                      [](Time at, const Node& node) { return at < node.t; });
  PathPlace place;
  place.node = static_cast<std::size_t>(after - nodes_.begin()) - 1;
  const Node& a = nodes_[place.node];
  place.T_odom_body = a.step->T_odom_body;
  if (after == nodes_.end()) return place;
  if (after->step->begins) return a.t == t ? std::optional(place) : std::nullopt;
  place.alpha = (t - a.t).s() / (after->t - a.t).s();
  place.T_odom_body = on_arc(a.step->T_odom_body, after->step->T_odom_body, place.alpha);
  return place;
}

void VehiclePath::forget_points_before(std::size_t node) {
  std::erase_if(points_, [&](const auto& entry) {
    const auto at = node_of(entry.first);
    return at && *at < node;
  });
}

const Increment* VehiclePath::newest_levelled() const {
  const auto node = std::find_if(nodes_.rbegin(), nodes_.rend(), [](const Node& n) {
    return n.step->levelled && n.step->g_odom_mps2.norm() > 0.0;
  });
  return node != nodes_.rend() ? node->step.get() : nullptr;
}

Vec3 VehiclePath::up_odom() const {
  const Increment* step = newest_levelled();
  return step != nullptr ? Vec3(-step->g_odom_mps2.normalized()) : up_unlevelled_;
}

double VehiclePath::degenerate_m() const {
  double sum_m = 0.0;
  for (std::size_t k = 1; k < nodes_.size(); ++k) {
    if (!nodes_[k].step->degenerate || !ties_to_before(k)) continue;
    sum_m += (nodes_[k].step->T_odom_body.p - nodes_[k - 1].step->T_odom_body.p).norm();
  }
  return sum_m;
}

}  // namespace rali::fleet
