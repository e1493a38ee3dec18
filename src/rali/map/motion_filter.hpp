#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/finding.hpp"
#include "rali/map/keyframe_view.hpp"
#include "rali/map/plane_grid.hpp"
#include "rali/map/range_image.hpp"
#include "rali/map/settings.hpp"
#include "rali/map/voxel_index.hpp"

namespace rali::map {

/// How a keyframe agrees with the walls of the map, its own included.
struct WallLooks {
  std::size_t looks = 0;   ///< places on planes that its rays hit or passed
  std::size_t passes = 0;  ///< of these, that a ray passed: often means a wrong pose
  /// The same for walls that another vehicle saw first, whatever the pose sigmas.
  std::size_t others_looks = 0, others_passes = 0;

  WallLooks& operator+=(const WallLooks& b) {
    looks += b.looks;
    passes += b.passes;
    others_looks += b.others_looks;
    others_passes += b.others_passes;
    return *this;
  }

  WallLooks& operator-=(const WallLooks& b) {
    looks -= b.looks;
    passes -= b.passes;
    others_looks -= b.others_looks;
    others_passes -= b.others_passes;
    return *this;
  }
};

/// The walls that a keyframe saw first, as tested by other keyframes.
struct WallsMade {
  std::size_t places = 0;
  std::size_t passed = 0;  ///< of these, by keyframes whose rays pass walls
};

/// Finds the places that were occupied only for a while: people, other vehicles.
///
/// Two passes over the keyframes. The first collects the places (cubes of 0.1 m with their mean
/// point), the second tests each keyframe's rays against each place near it. A place is removed if
/// enough keyframes, over enough time, had rays through it and few got a return from it. A place
/// that no later ray passed is kept: nothing is removed without evidence.
///
/// Vehicles of the fleet need no such evidence, because their poses are known: places seen only
/// near them while they were there are removed. Places on a surface that extends beyond (the floor
/// below, the wall beside) are kept.
///
/// Protection from wrong poses: keyframes whose rays pass walls are not used, nor those whose pose
/// sigma is much larger, or much smaller, than that of the keyframes that saw the place. The stated
/// covariance itself is no criterion, because neighbouring keyframes share almost all of it.
class MotionFilter {
 public:
  explicit MotionFilter(const DynamicSettings& settings);

  /// First pass.
  void collect(const KeyframeView& keyframe);
  /// Second pass, after all keyframes were collected, in the same order.
  void look(const KeyframeView& keyframe, Executor& executor);
  /// Decides. Removes nothing, with a Finding, if more than `plane_fraction_max` of the walls would
  /// be removed: then the poses are wrong.
  void decide(FindingList& findings);

  /// After the second pass: of each keyframe, in the order of collect(). Places that rays of the
  /// vehicle that saw them first pass within seconds are no walls: twigs, the edge of a trunk, the
  /// rear of a car ahead. Within seconds a vehicle's own poses are accurate.
  [[nodiscard]] std::vector<WallLooks> walls_seen() const;
  [[nodiscard]] std::vector<WallsMade> walls_made() const;

  /// After decide(): whether this place was occupied only for a while.
  [[nodiscard]] bool is_removed(const geometry::Vec3& p_map_m) const;

  [[nodiscard]] std::size_t places() const { return places_.size(); }

  [[nodiscard]] std::size_t removed() const { return removed_; }

  /// Keyframes that were rejected because their rays pass walls.
  [[nodiscard]] std::size_t suspected() const { return suspected_; }

 private:
  static constexpr std::uint32_t kNoWall = 0xffffffffU;

  struct Place {
    VoxelKey key = kNoVoxel;
    float x_m = 0.0F, y_m = 0.0F, z_m = 0.0F;  ///< mean point, offset from the corner
    float pose_m2 = 0.0F;                      ///< mean variance of the poses that saw it
    std::uint32_t points = 0;
    std::uint32_t peer_points = 0;       ///< of these, while a vehicle of the fleet was there
    std::uint32_t maker = 0;             ///< the keyframe that saw it first
    std::uint16_t hits = 0, passes = 0;  ///< keyframes
    float first_pass_s = 0.0F, last_pass_s = 0.0F;
    std::uint32_t wall = kNoWall;  ///< its normal in `normals_map_`, if it is on a plane
    bool removed = false;
    bool looked_through = false;  ///< by a keyframe whose rays pass walls
    bool fleeting = false;        ///< passed within seconds of its first sight
  };

  /// What a keyframe has seen of walls.
  struct Looker {
    std::uint8_t vehicle = 0;
    Time t;
    double pose_m2 = 0.0;
    WallLooks walls;
    std::vector<std::uint32_t> passed;  ///< places
  };

  /// Places of one cube of 0.8 m are stored together: a keyframe skips the cubes it cannot see.
  struct Tile {
    VoxelKey key = kNoVoxel;
    std::size_t begin = 0, end = 0;
  };

  [[nodiscard]] geometry::Vec3 position(const Place& place) const;
  [[nodiscard]] bool is_near_peer(const KeyframeView& keyframe, const geometry::Vec3& p_map) const;
  void sort_into_tiles();
  void mark_planes();
  [[nodiscard]] SightLimits sight_limits() const;
  void find_seen_tiles(const geometry::SE3& T_lidar_map, const SightLimits& limits);
  [[nodiscard]] Sight look_at(const Place& place, const geometry::SE3& T_lidar_map,
                              const SightLimits& limits) const;
  [[nodiscard]] bool is_comparable(const Place& place, double looker_pose_m2) const;
  [[nodiscard]] bool grazes(const Place& place, const geometry::SE3& T_lidar_map,
                            const geometry::Vec3& p_lidar_m, const SightLimits& limits) const;
  [[nodiscard]] WallLooks look_of(const Looker& looker, const Place& place, bool passed) const;
  void look_at_walls(Looker& looker);
  [[nodiscard]] bool sees_through_walls(const WallLooks& walls) const;
  void count(float t_s, double looker_pose_m2);
  void mark_looked_through();
  [[nodiscard]] bool is_empty_place(const Place& place) const;
  [[nodiscard]] bool is_of_peer(const Place& place) const;
  [[nodiscard]] double plane_fraction_lost() const;

  DynamicSettings settings_;
  VoxelIndex index_;                 ///< key -> number in `rank_`
  std::vector<Place> places_;        ///< by first sight, by tile after the first pass
  std::vector<std::uint32_t> rank_;  ///< number by first sight -> place
  std::vector<Tile> tiles_;
  std::vector<geometry::Vec3f> normals_map_;  ///< of the cubes that hold a plane
  PlaneGrid fixed_;                           ///< places that were seen while no vehicle was there
  RangeImage image_;
  std::vector<std::size_t> near_;      ///< tiles that the keyframe may see
  std::vector<Sight> lines_of_sight_;  ///< by place: result for the current keyframe
  std::vector<Looker> lookers_;        ///< by keyframe
  std::size_t next_looker_ = 0;        ///< of the second pass
  Time t_first_;
  bool has_time_ = false;
  std::size_t removed_ = 0;
  std::size_t suspected_ = 0;
};

}  // namespace rali::map
