#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "rali/fleet/facts/fact_store.hpp"
#include "rali/fleet/node/node.hpp"
#include "rali/map/explore_grid.hpp"
#include "rali/wire/cloud_pack.hpp"
#include "rali/wire/messages.hpp"

namespace rali::host {

/// A node's knowledge of the map, as immutable values.
struct MapNews {
  std::vector<fleet::FactPtr> facts;                        ///< new since the last news
  std::vector<std::pair<KeyframeId, geometry::SE3>> poses;  ///< T_map_body, ascending
  fleet::StreamKey own;                                     ///< of this start of this vehicle
  std::optional<geometry::SE3> T_map_local;                 ///< of `own`
};

/// Collects news of a node. It only copies, which is fast enough for a step.
class MapNewsReader {
 public:
  [[nodiscard]] MapNews read(const fleet::Node& node);

 private:
  std::map<fleet::StreamKey, fleet::SeqSet> seen_;  ///< facts
};

/// The fleet's map as this vehicle can draw it: the keyframes with available points, at their poses
/// of the last table. Newer keyframes of a vehicle are placed relative to its last keyframe in the
/// table. It is not used by any estimate.
class MapPicture {
 public:
  explicit MapPicture(const map::ExploreSettings& grid) : grid_(grid) {}

  /// Takes new facts and new poses.
  void update(const MapNews& news);

  /// Points of keyframes that are new or were moved by more than 0.1 m since the last call; fields
  /// x y z (float32), keyframe (uint32), vehicle (uint8). Frame map. Empty: no news.
  [[nodiscard]] std::optional<wire::PackedCloud> take_delta(Time t);

  /// One point per cube of all keyframes, with `age_s` since the first keyframe that observed it.
  /// Cubes grow until at most `points_max` are left.
  [[nodiscard]] std::optional<wire::PackedCloud> whole(Time t, double voxel_m,
                                                       std::size_t points_max) const;

  /// Empty before any point is available.
  [[nodiscard]] std::optional<wire::GridMessage> grid(Time t) const;

  /// The largest shift of a keyframe by the last update that moved any.
  struct Move {
    double metres = 0.0;
    VehicleId vehicle;
    std::size_t keyframes = 0;  ///< moved by more than a centimetre
  };

  [[nodiscard]] const Move& last_move() const { return move_; }

  /// Positions of a vehicle's keyframes in map, by time; and whether the LiDAR was degenerate.
  struct PathPoint {
    Time t;
    geometry::Vec3 p_map_m;
    bool degenerate = false;
  };

  [[nodiscard]] std::map<VehicleId, std::vector<PathPoint>> paths() const;

  /// T_map_local of each vehicle's frame `local`, at its newest keyframe; only for vehicles that
  /// are placed in the map.
  [[nodiscard]] const std::map<VehicleId, geometry::SE3>& T_map_local() const { return frames_; }

  [[nodiscard]] std::size_t keyframes() const { return keyframes_.size(); }

 private:
  struct Keyframe {
    fleet::FactPtr points;  ///< null: not available
    Time t;
    geometry::SE3 T_local_body;
    bool has_step = false;  ///< T_local_body is known
    bool degenerate = false;
    geometry::SE3 T_drawn;  ///< in the last delta
    std::optional<geometry::SE3> T_map_body;
    bool in_grid = false;
    bool is_new = true;  ///< for the next delta
  };

  void take(const fleet::FactPtr& fact);
  void place(const MapNews& news);
  void move_to(Keyframe& keyframe, VehicleId vehicle, const geometry::SE3& T_map_body);
  void draw(KeyframeId id, Keyframe& keyframe);

  map::ExploreGrid grid_;
  std::map<KeyframeId, Keyframe> keyframes_;
  std::map<VehicleId, geometry::SE3> frames_;  ///< T_map_local
  Move move_, moving_;
};

}  // namespace rali::host
