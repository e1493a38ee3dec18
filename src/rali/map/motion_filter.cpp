#include "rali/map/motion_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "rali/base/assert.hpp"

namespace rali::map {
namespace {

constexpr double kTile_m = 0.8;
constexpr double kTileRadius_m = 0.693;  ///< half the diagonal of a tile
/// Tiles per block of the executor.
constexpr std::size_t kTilesAtOnce = 64;

/// Places this near to a wall that extends beyond belong to the wall.
constexpr double kOnPlane_m = 0.05;
/// With fewer places on planes, the test of a keyframe against walls is not significant.
constexpr std::size_t kPlanePlacesMin = 50;
/// Limit for walls that another vehicle saw first. Rays of a keyframe pass 2.4 % of them at most in
/// correct maps of the campaign, 43 to 99 % with wrong start poses or an anchor that was moved.
constexpr double kOthersFractionMax = 0.2;

/// Variance per axis of the position of a place 10 m away, by the keyframe's own covariance.
double pose_variance_m2(const KeyframeView& keyframe) {
  const double position_m2 = keyframe.covariance.bottomRightCorner<3, 3>().trace();
  const double rotation_rad2 = keyframe.covariance.topLeftCorner<3, 3>().trace();
  return std::max(position_m2 + 100.0 * rotation_rad2, 0.0) / 3.0;
}

}  // namespace

MotionFilter::MotionFilter(const DynamicSettings& settings) : settings_(settings) {}

void MotionFilter::collect(const KeyframeView& keyframe) {
  const auto number = static_cast<std::uint32_t>(lookers_.size());
  lookers_.push_back({keyframe.vehicle, keyframe.t, pose_variance_m2(keyframe), {}, {}});
  if (!is_usable(keyframe)) return;
  RALI_ASSERT(tiles_.empty());  // the first pass ends with the first look()
  const auto pose_m2 = static_cast<float>(lookers_.back().pose_m2);
  for (std::size_t i = 0; i < keyframe.size(); ++i) {
    const geometry::Vec3 p_map = keyframe.T_map_body * keyframe.point_body(i);
    const VoxelKey key = voxel_key(p_map, settings_.voxel_m);
    if (key == kNoVoxel) continue;
    const VoxelIndex::Slot slot = index_.insert(key);
    if (slot.is_new) {
      places_.emplace_back().key = key;
      places_.back().maker = number;
    }
    Place& place = places_[slot.index];
    ++place.points;
    if (is_near_peer(keyframe, p_map)) ++place.peer_points;
    const geometry::Vec3f offset = (p_map - voxel_corner(key, settings_.voxel_m)).cast<float>();
    const auto n = static_cast<float>(place.points);
    place.x_m += (offset.x() - place.x_m) / n;
    place.y_m += (offset.y() - place.y_m) / n;
    place.z_m += (offset.z() - place.z_m) / n;
    place.pose_m2 += (pose_m2 - place.pose_m2) / n;
  }
}

bool MotionFilter::is_near_peer(const KeyframeView& keyframe, const geometry::Vec3& p_map) const {
  for (const geometry::Vec3& peer_map : keyframe.others_map_m) {
    const geometry::Vec3 d = p_map - peer_map;
    const bool level = d.head<2>().norm() < settings_.peer_radius_m;
    if (level && std::abs(d.z()) < settings_.peer_height_m) return true;
  }
  return false;
}

geometry::Vec3 MotionFilter::position(const Place& place) const {
  return voxel_corner(place.key, settings_.voxel_m) +
         geometry::Vec3{static_cast<double>(place.x_m), static_cast<double>(place.y_m),
                        static_cast<double>(place.z_m)};
}

void MotionFilter::sort_into_tiles() {
  std::vector<VoxelKey> tile_of(places_.size());
  for (std::size_t i = 0; i < places_.size(); ++i) {
    tile_of[i] = voxel_key(position(places_[i]), kTile_m);
  }
  std::vector<std::uint32_t> order(places_.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return tile_of[a] < tile_of[b]; });
  std::vector<Place> sorted(places_.size());
  rank_.resize(places_.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    sorted[i] = places_[order[i]];
    rank_[order[i]] = static_cast<std::uint32_t>(i);
    const VoxelKey tile = tile_of[order[i]];
    if (tiles_.empty() || tiles_.back().key != tile) tiles_.push_back({tile, i, i});
    tiles_.back().end = i + 1;
  }
  places_ = std::move(sorted);
  mark_planes();
}

void MotionFilter::mark_planes() {
  PlaneGrid all;
  for (const Place& place : places_) {
    all.add(position(place));
    if (place.peer_points < place.points) fixed_.add(position(place));
  }
  const std::vector<std::optional<geometry::Vec3>> normals = all.normals();
  std::vector<std::uint32_t> wall_of(normals.size(), kNoWall);
  for (std::size_t cube = 0; cube < normals.size(); ++cube) {
    if (!normals[cube]) continue;
    wall_of[cube] = static_cast<std::uint32_t>(normals_map_.size());
    normals_map_.push_back(normals[cube]->cast<float>());
  }
  for (Place& place : places_) {
    const auto cube = all.find(position(place));
    if (cube) place.wall = wall_of[*cube];
  }
}

void MotionFilter::look(const KeyframeView& keyframe, Executor& executor) {
  RALI_ASSERT(next_looker_ < lookers_.size());
  Looker& looker = lookers_[next_looker_++];
  if (!is_usable(keyframe) || places_.empty()) return;
  if (tiles_.empty()) sort_into_tiles();
  if (!has_time_) t_first_ = keyframe.t;
  has_time_ = true;
  image_.build(keyframe);
  const geometry::SE3 T_map_lidar = keyframe.T_map_body * keyframe.T_body_lidar;
  const geometry::SE3 T_lidar_map = T_map_lidar.inverse();
  const SightLimits limits = sight_limits();
  find_seen_tiles(T_lidar_map, limits);
  lines_of_sight_.resize(places_.size());
  // Only one block writes each tile, so the order of the blocks does not matter.
  executor.for_blocks(near_.size(), kTilesAtOnce,
                      [&](std::size_t, std::size_t begin, std::size_t end) {
                        for (std::size_t i = begin; i < end; ++i) {
                          const Tile& tile = tiles_[near_[i]];
                          for (std::size_t k = tile.begin; k < tile.end; ++k) {
                            lines_of_sight_[k] = look_at(places_[k], T_lidar_map, limits);
                          }
                        }
                      });
  look_at_walls(looker);
  if (sees_through_walls(looker.walls)) {
    ++suspected_;
    mark_looked_through();
  } else {
    count(static_cast<float>(seconds_between(t_first_, keyframe.t)), looker.pose_m2);
  }
}

/// A vehicle sees thousands of its own walls, but only a few hundred of another vehicle's wrongly
/// placed ones. So walls of others count apart, with a higher limit, because people who stand are
/// among them, too.
bool MotionFilter::sees_through_walls(const WallLooks& walls) const {
  const auto more = [](std::size_t passes, std::size_t looks, double fraction) {
    return looks >= kPlanePlacesMin &&
           static_cast<double>(passes) > fraction * static_cast<double>(looks);
  };
  return more(walls.passes, walls.looks, settings_.look_fraction_max) ||
         more(walls.others_passes, walls.others_looks, kOthersFractionMax);
}

SightLimits MotionFilter::sight_limits() const {
  return {settings_.range_m, settings_.margin_m,       0.5 * settings_.voxel_m,
          settings_.voxel_m, 0.5 * settings_.margin_m, settings_.thin_m};
}

/// Skips tiles behind walls: most places of a building are then never tested one by one.
void MotionFilter::find_seen_tiles(const geometry::SE3& T_lidar_map, const SightLimits& limits) {
  near_.clear();
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    const geometry::Vec3 middle_map =
        voxel_corner(tiles_[i].key, kTile_m) + geometry::Vec3::Constant(0.5 * kTile_m);
    if (image_.may_see(T_lidar_map * middle_map, kTileRadius_m, limits)) near_.push_back(i);
  }
}

bool MotionFilter::is_comparable(const Place& place, double looker_pose_m2) const {
  const double between_m2 = std::abs(looker_pose_m2 - static_cast<double>(place.pose_m2));
  return between_m2 <= settings_.pose_sigma_max_m * settings_.pose_sigma_max_m;
}

Sight MotionFilter::look_at(const Place& place, const geometry::SE3& T_lidar_map,
                            const SightLimits& limits) const {
  const geometry::Vec3 p_lidar_m = T_lidar_map * position(place);
  const Sight sight = image_.look(p_lidar_m, limits);
  const bool along = sight == Sight::kPassed && grazes(place, T_lidar_map, p_lidar_m, limits);
  return along ? Sight::kUnknown : sight;
}

/// Rays start up to 0.1 m from the keyframe's pose, because the LiDAR moves during the scan. In
/// line with a wall, this error suffices to put all of the wall on the wrong side of the rays, as
/// in a doorway. So a ray has passed a wall only if it ends behind its plane by the size of a
/// place.
bool MotionFilter::grazes(const Place& place, const geometry::SE3& T_lidar_map,
                          const geometry::Vec3& p_lidar_m, const SightLimits& limits) const {
  if (place.wall == kNoWall) return false;
  const geometry::Vec3 normal_lidar = T_lidar_map.R * normals_map_[place.wall].cast<double>();
  return std::abs(normal_lidar.dot(p_lidar_m)) * limits.margin_m <
         limits.radius_m * p_lidar_m.norm();
}

WallLooks MotionFilter::look_of(const Looker& looker, const Place& place, bool passed) const {
  const std::size_t others = lookers_[place.maker].vehicle != looker.vehicle ? 1 : 0;
  const std::size_t own = is_comparable(place, looker.pose_m2) ? 1 : 0;
  return {own, passed ? own : 0, others, passed ? others : 0};
}

void MotionFilter::look_at_walls(Looker& looker) {
  constexpr double kFleeting_s = 2.5;
  for (const std::size_t i : near_) {
    for (std::size_t k = tiles_[i].begin; k < tiles_[i].end; ++k) {
      Place& place = places_[k];
      if (place.wall == kNoWall || lines_of_sight_[k] == Sight::kUnknown) continue;
      const bool passed = lines_of_sight_[k] == Sight::kPassed;
      looker.walls += look_of(looker, place, passed);
      if (!passed) continue;
      looker.passed.push_back(static_cast<std::uint32_t>(k));
      const Looker& maker = lookers_[place.maker];
      place.fleeting |= maker.vehicle == looker.vehicle &&
                        std::abs(seconds_between(maker.t, looker.t)) < kFleeting_s;
    }
  }
}

std::vector<WallLooks> MotionFilter::walls_seen() const {
  std::vector<WallLooks> out;
  for (const Looker& looker : lookers_) {
    WallLooks& walls = out.emplace_back(looker.walls);
    for (const std::uint32_t k : looker.passed) {
      if (places_[k].fleeting) walls -= look_of(looker, places_[k], true);
    }
  }
  return out;
}

void MotionFilter::mark_looked_through() {
  for (const std::size_t i : near_) {
    for (std::size_t k = tiles_[i].begin; k < tiles_[i].end; ++k) {
      if (places_[k].wall == kNoWall || lines_of_sight_[k] != Sight::kPassed) continue;
      places_[k].looked_through = true;
    }
  }
}

std::vector<WallsMade> MotionFilter::walls_made() const {
  std::vector<WallsMade> out(lookers_.size());
  for (const Place& place : places_) {
    if (place.wall == kNoWall || place.fleeting) continue;
    ++out[place.maker].places;
    if (place.looked_through) ++out[place.maker].passed;
  }
  return out;
}

void MotionFilter::count(float t_s, double looker_pose_m2) {
  for (const std::size_t i : near_) {
    for (std::size_t k = tiles_[i].begin; k < tiles_[i].end; ++k) {
      Place& place = places_[k];
      if (!is_comparable(place, looker_pose_m2)) continue;
      if (lines_of_sight_[k] == Sight::kHit && place.hits < 0xffff) ++place.hits;
      if (lines_of_sight_[k] != Sight::kPassed || place.passes == 0xffff) continue;
      if (place.passes++ == 0) place.first_pass_s = t_s;
      place.last_pass_s = t_s;
    }
  }
}

bool MotionFilter::is_empty_place(const Place& place) const {
  const double passes = place.passes;
  const double looks = passes + place.hits;
  const double apart_s = static_cast<double>(std::abs(place.last_pass_s - place.first_pass_s));
  const bool long_enough = settings_.passes_min < 2.0 || apart_s >= settings_.separation_s;
  return passes >= settings_.passes_min && passes > settings_.pass_fraction * looks && long_enough;
}

double MotionFilter::plane_fraction_lost() const {
  std::size_t on_planes = 0, lost = 0;
  for (const Place& place : places_) {
    if (place.wall == kNoWall) continue;
    ++on_planes;
    if (place.removed) ++lost;
  }
  return on_planes == 0 ? 0.0 : static_cast<double>(lost) / static_cast<double>(on_planes);
}

bool MotionFilter::is_of_peer(const Place& place) const {
  return place.peer_points == place.points &&
         fixed_.distance_to_planes_m(position(place)) > kOnPlane_m;
}

void MotionFilter::decide(FindingList& findings) {
  removed_ = 0;
  for (Place& place : places_) {
    place.removed = is_empty_place(place) || is_of_peer(place);
    if (place.removed) ++removed_;
  }
  const double fraction = plane_fraction_lost();
  if (removed_ == 0 || fraction <= settings_.plane_fraction_max) return;
  for (Place& place : places_) place.removed = false;
  removed_ = 0;
  Finding finding;
  finding.id = "map.dynamic";
  finding.text = fmt::format(
      "moving objects were not removed: {:.1f} % of the walls would have "
      "gone with them (limit {:.1f} %)",
      100.0 * fraction, 100.0 * settings_.plane_fraction_max);
  finding.effect = "people and vehicles stay in the map";
  finding.remedy = "Rays through walls mean wrong poses: check the map for doubled walls.";
  finding.value = fraction;
  finding.limit = settings_.plane_fraction_max;
  findings.push_back(std::move(finding));
}

bool MotionFilter::is_removed(const geometry::Vec3& p_map_m) const {
  const auto number = index_.find(voxel_key(p_map_m, settings_.voxel_m));
  if (!number) return false;
  return places_[rank_.empty() ? *number : rank_[*number]].removed;
}

}  // namespace rali::map
