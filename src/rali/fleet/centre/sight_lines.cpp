#include "rali/fleet/centre/sight_lines.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "rali/ranging/range_model.hpp"
#include "rali/ranging/seen_space.hpp"

namespace rali::fleet {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kCell_m = 1.6;     ///< of planes: about the largest
constexpr double kPoint_m = 0.15;   ///< cube that holds a point, or has a neighbour that does
constexpr double kGraze = 0.25;     ///< sine of the least angle between line and face
constexpr double kLattice_m = 0.5;  ///< of the points on lines that are tested once
constexpr double kApart_m = 0.4;    ///< faces seen from one side nearer than this are one

/// A face on the line.
struct Crossing {
  bool from_behind = false;
  double at_m = 0.0;
  auto operator<=>(const Crossing&) const = default;
};

}  // namespace

SightLines::SightLines(std::span<const PathSubmap> pieces, const PathFrames& frames,
                       std::size_t group) {
  std::vector<Vec3> middles;
  for (const PathSubmap& piece : pieces) {
    if (frames.group[piece.path] != group) continue;
    const SE3 T_map_ref = frames.T_map_odom[piece.path] * piece.T_odom_ref;
    for (places::Plane plane : piece.submap.planes()) {
      plane.q_m = T_map_ref * plane.q_m;
      plane.n = T_map_ref.R * plane.n;
      middles.push_back(plane.q_m);
      planes_.push_back(plane);
    }
    places_m_.push_back(T_map_ref.p);
    for (std::size_t i = 0; i < piece.submap.points(); ++i) {
      const Vec3 p_m = piece.submap.point_m(i).cast<double>();
      (void)points_.insert(map::voxel_key(T_map_ref * p_m, kPoint_m));
    }
  }
  index_.build(middles, kCell_m);
}

bool SightLines::leaves(const Vec3& p_map_m, const Vec3& q_map_m) {
  const auto between = [this](const Vec3& p_m, const Vec3& q_m) { return surfaces(p_m, q_m); };
  return ranging::leaves_seen_space(p_map_m, q_map_m, [&](const Vec3& x_m) {
    const map::VoxelKey key = map::voxel_key(x_m, kLattice_m);
    if (key == map::kNoVoxel) return false;
    const map::VoxelIndex::Slot slot = tested_.insert(key);
    if (slot.is_new) {
      const Vec3 middle_m = map::voxel_corner(key, kLattice_m) + Vec3::Constant(0.5 * kLattice_m);
      outside_.push_back(ranging::is_outside(middle_m, places_m_, between));
    }
    return static_cast<bool>(outside_[slot.index]);
  });
}

bool SightLines::filled(const Vec3& p_map_m) const {
  for (int k = 0; k < 27; ++k) {
    const Vec3 off(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
    if (points_.find(map::voxel_key(p_map_m + kPoint_m * off, kPoint_m))) return true;
  }
  return false;
}

int SightLines::surfaces(const Vec3& p_map_m, const Vec3& q_map_m) const {
  const double length_m = (q_map_m - p_map_m).norm();
  if (!(length_m > 0.0)) return 0;
  const Vec3 along = (q_map_m - p_map_m) / length_m;
  std::vector<Crossing> crossings;
  const int steps = static_cast<int>(length_m / kCell_m) + 1;
  const double step_m = length_m / steps;
  for (int k = 0; k < steps; ++k) {
    const double start_m = k * step_m, end_m = start_m + step_m;
    const Vec3 middle = p_map_m + 0.5 * (start_m + end_m) * along;
    index_.near(middle, 0.5 * step_m + kCell_m, [&](std::uint32_t i) {
      const places::Plane& plane = planes_[i];
      const double slope = plane.n.dot(along);
      if (std::abs(slope) < kGraze) return;
      const double at_m = plane.n.dot(plane.q_m - p_map_m) / slope;
      if (at_m < start_m || at_m >= end_m) return;
      const Vec3 x = p_map_m + at_m * along;
      if ((x - plane.q_m).norm() <= plane.radius_m && filled(x)) {
        crossings.push_back({slope > 0.0, at_m});
      }
    });
  }
  std::sort(crossings.begin(), crossings.end());
  int surfaces = 0;
  const Crossing* last = nullptr;
  for (const Crossing& c : crossings) {
    const bool same =
        last != nullptr && last->from_behind == c.from_behind && c.at_m - last->at_m < kApart_m;
    if (!same) ++surfaces;
    last = &c;
  }
  return surfaces;
}

void suspect_through_walls(std::span<const PathSubmap> pieces, const PathFrames& frames,
                           const ranging::RangingSettings& settings, FramesAre frames_are,
                           JointRanges& joint) {
  /// The line tested last, by pair.
  struct Asked {
    Time t;
    Vec3 p_m, q_m;
    bool blocked = false;
  };

  const ranging::SightSettings& s = settings.sight;
  if (!s.use) return;
  std::map<std::size_t, SightLines> lines_of_sight;
  std::map<int, Asked> last;
  for (JointRange& r : joint.ranges) {
    const AntennaPair& pair = joint.pairs[static_cast<std::size_t>(r.pair)];
    const std::size_t group = frames.group[pair.a.path];
    if (frames.group[pair.b.path] != group) continue;
    const Vec3 p_m = frames.T_map_odom[pair.a.path] * r.a.p_odom_m;
    const Vec3 q_m = frames.T_map_odom[pair.b.path] * r.b.p_odom_m;
    const double length_m = (q_m - p_m).norm();
    if (!(length_m >= 3.0 * s.end_m)) continue;
    const auto [known, is_new] = last.try_emplace(r.pair);
    Asked& asked = known->second;
    const bool fresh = !is_new && (r.t - asked.t).s() < s.valid_s &&
                       (p_m - asked.p_m).norm() < s.valid_m && (q_m - asked.q_m).norm() < s.valid_m;
    if (!fresh) {
      SightLines& lines = lines_of_sight.try_emplace(group, pieces, frames, group).first->second;
      const Vec3 end = s.end_m / length_m * (q_m - p_m);
      const bool blocked = lines.surfaces(p_m + end, q_m - end) >= s.surfaces ||
                           (frames_are == FramesAre::kFound && lines.leaves(p_m + end, q_m - end));
      asked = {r.t, p_m, q_m, blocked};
    }
    r.blocked = asked.blocked;
    if (!r.blocked) continue;
    const double sigma_m = ranging::sigma_of(r.range_m, settings.limits, 0.0);
    r.sigma_m = std::max(r.sigma_m, s.sigma_factor * sigma_m);
  }
}

}  // namespace rali::fleet
