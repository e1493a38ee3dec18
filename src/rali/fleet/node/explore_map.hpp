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

/// The grid in which frontiers are searched, and the places the vehicles have visited. Drawing a
/// keyframe takes milliseconds, so only jobs do it.
class ExploreMap {
 public:
  explicit ExploreMap(const map::ExploreSettings& settings) : grid_(settings) {}

  /// Is used from the next draw() on.
  void add(const FactPtr& fact);

  /// Moves drawn keyframes to their estimated poses, and draws those received since the last call.
  /// @return false: stopped early; the next call draws what is missing
  [[nodiscard]] bool draw(const Placement& placed, StopFlag stop);

  /// Frees the points: the grid keeps outlines of its own. The points are needed again as long as
  /// vehicles can be removed from the map and return.
  void forget_drawn_points();

  [[nodiscard]] const map::ExploreGrid& grid() const { return grid_; }

  /// The degenerate direction of the LiDAR at a place: that of the nearest node of any path. Valid
  /// until the next draw().
  [[nodiscard]] DegenerateAxisAt degenerate_axis() const;

  /// Height of the bodies near a place [m].
  [[nodiscard]] double height_m(const geometry::Vec2& place_map_m) const;

  /// Number of keyframes since a time that are farther than `apart_m` from all earlier ones.
  [[nodiscard]] std::size_t new_places_since(Time t, double apart_m) const;

 private:
  /// In the vehicle's odometry frame.
  struct Node {
    StreamKey stream;
    Time t;
    geometry::SE3 T_odom_body;
    std::optional<std::uint32_t> keyframe;
    std::optional<geometry::Vec2> degenerate_axis_odom;  ///< unit; nothing: not degenerate
  };

  /// Likewise, in the map frame.
  struct Seen {
    Time t;
    geometry::Vec3 p_map_m = geometry::Vec3::Zero();
    bool keyframe = false;
    std::optional<geometry::Vec2> degenerate_axis;
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
