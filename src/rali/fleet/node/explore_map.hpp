#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "rali/base/stop_flag.hpp"
#include "rali/fleet/facts/fact_store.hpp"
#include "rali/fleet/node/placement.hpp"
#include "rali/fleet/rounds/anchor_choice.hpp"
#include "rali/map/explore_grid.hpp"

namespace rali::fleet {

/// The grid in which frontiers are searched, and where vehicles have been. To draw a keyframe takes
/// milliseconds: only jobs do it.
class ExploreMap {
 public:
  explicit ExploreMap(const map::ExploreSettings& settings) : grid_(settings) {}

  /// Counts from the next draw() on.
  void add(const FactPtr& fact);

  /// Keyframes lie as an estimate has them, and those that have come since the last call are drawn.
  /// @return false: stopped on the way; the next call makes up for what is missing
  [[nodiscard]] bool draw(const Placement& placed, StopFlag stop);

  /// The grid keeps outlines of its own. While vehicles may still be taken out of the map and come
  /// back, the points are needed again.
  void forget_drawn_points();

  [[nodiscard]] const map::ExploreGrid& grid() const { return grid_; }

  /// The direction that a LiDAR will not tell at a place: as at the nearest node of any path.
  /// Valid until the next draw().
  [[nodiscard]] BlindAxisAt blind_axis() const;

  /// Height of the bodies near a place [m].
  [[nodiscard]] double height_m(const geometry::Vec2& place_map_m) const;

  /// Keyframes made from a time on, farther than `apart_m` from all that were made before it.
  [[nodiscard]] std::size_t new_places_since(Time t, double apart_m) const;

 private:
  /// As the vehicle's odometry has it.
  struct Node {
    StreamKey stream;
    Time t;
    geometry::SE3 T_odom_body;
    std::optional<std::uint32_t> keyframe;
    std::optional<geometry::Vec2> blind_axis_odom;  ///< unit; nothing: the LiDAR sees all
  };

  /// Likewise, in the map.
  struct Seen {
    Time t;
    geometry::Vec3 p_map_m = geometry::Vec3::Zero();
    bool keyframe = false;
    std::optional<geometry::Vec2> blind_axis;
  };

  [[nodiscard]] bool move_drawn(const Placement& placed, StopFlag stop);
  [[nodiscard]] bool draw_new(const Placement& placed, StopFlag stop);
  void list_seen(const Placement& placed);
  [[nodiscard]] const Node* node_of(KeyframeId keyframe) const;
  [[nodiscard]] const Seen* nearest(const geometry::Vec2& place_map_m) const;

  std::map<StreamKey, std::map<std::uint32_t, Node>> nodes_;  ///< by number
  std::map<KeyframeId, const Node*> node_of_;
  std::map<KeyframeId, FactPtr> points_;
  map::ExploreGrid grid_;
  std::set<KeyframeId> drawn_;
  std::vector<Seen> seen_;  ///< all nodes of paths that are placed
};

}  // namespace rali::fleet
