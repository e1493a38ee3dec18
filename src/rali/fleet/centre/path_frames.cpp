#include "rali/fleet/centre/path_frames.hpp"

#include <algorithm>
#include <numbers>

#include "rali/fleet/path/level.hpp"

namespace rali::fleet {

using geometry::SE3;
using geometry::Vec3;

namespace {

/// The map of a group in its first vehicle's levelled odom.
SE3 T_level_map(const VehiclePath& path) {
  return level_start(T_level_odom(path) * path.nodes().front().step->T_odom_body, Vec3::UnitZ());
}

}  // namespace

SE3 T_level_odom(const VehiclePath& path) {
  SE3 T;
  T.R = geometry::rotation_between(path.up_odom(), Vec3::UnitZ());
  return T;
}

SE3 T_map_odom_alone(const VehiclePath& path) {
  return T_level_map(path).inverse() * T_level_odom(path);
}

StreamKey stream_of(const VehiclePath& path) { return {path.vehicle(), path.epoch()}; }

const VehiclePath* path_of(std::span<const VehiclePath> paths, StreamKey stream) {
  for (const VehiclePath& path : paths) {
    if (stream_of(path) == stream) return &path;
  }
  return nullptr;
}

std::vector<std::size_t> begins_of(std::span<const VehiclePath> paths,
                                   const SeparatorPrior* before) {
  std::vector<std::size_t> begins(paths.size(), 0);
  if (before == nullptr) return begins;
  for (const SeparatorPath& known : before->paths) {
    for (std::size_t i = 0; i < paths.size(); ++i) {
      if (stream_of(paths[i]) != known.stream) continue;
      begins[i] = paths[i].index_of(known.node).value_or(0);
    }
  }
  return begins;
}

void add_ranges(std::span<const VehiclePath> paths, const JointRanges& ranges,
                FrameSolver& solver) {
  std::vector<SE3> T_level;
  for (const VehiclePath& path : paths) T_level.push_back(T_level_odom(path));
  for (const JointRange& r : ranges.ranges) {
    const AntennaPair& pair = ranges.pairs[static_cast<std::size_t>(r.pair)];
    const auto covariance = [&](std::size_t path, const RangeEnd& end) {
      const geometry::Mat3 P =
          paths[path].nodes()[end.place.node].step->covariance.bottomRightCorner<3, 3>();
      return geometry::Mat3(T_level[path].R * P * T_level[path].R.transpose());
    };
    RangeObservation o;
    o.t = r.t;
    o.x_a_m = T_level[pair.a.path] * r.a.p_odom_m;
    o.y_b_m = T_level[pair.b.path] * r.b.p_odom_m;
    o.x_covariance_m2 = covariance(pair.a.path, r.a);
    o.y_covariance_m2 = covariance(pair.b.path, r.b);
    o.range_m = r.range_m;
    o.sigma_m = r.sigma_m;
    o.a_rests = r.a.at_rest;
    o.b_rests = r.b.at_rest;
    solver.add_range(stream_of(paths[pair.a.path]), stream_of(paths[pair.b.path]), o);
  }
}

void add_start(const VehiclePath& relative_to, const VehiclePath& path, const SE3& T_relative_path,
               double sigma_m, double sigma_rad, InitSettings settings, FrameSolver& solver) {
  settings.prior.xyz_m = sigma_m;
  settings.prior.yaw_deg = sigma_rad * 180.0 / std::numbers::pi;
  const SE3 T_first = T_level_map(path);
  const SE3 T_relative = T_level_map(relative_to);
  const YawPose T = YawPose::of(T_relative * T_relative_path * T_first.inverse());
  PoseEvidence prior = prior_evidence(stream_of(path), stream_of(relative_to), T, settings);
  // The measured point is the position of the body, not the origin of odom.
  prior.pivot_a_m = T_first.p;
  prior.place_b_m = (T_relative * T_relative_path).p;
  solver.add_evidence(prior);
}

PathFrames frames_of(std::span<const VehiclePath> paths, const FleetFrames& frames) {
  PathFrames out;
  out.group.assign(paths.size(), 0);
  out.T_map_odom.assign(paths.size(), SE3{});
  out.decided_by.assign(paths.size(), std::nullopt);
  const auto index_of = [&](StreamKey key) {
    std::size_t i = 0;
    while (i < paths.size() && stream_of(paths[i]) != key) ++i;
    return i;
  };
  for (const SolvedGroup& group : frames.groups) {
    std::vector<std::size_t> members;
    SE3 T_map_ref;
    for (std::size_t k = 0; k < group.frames.keys.size(); ++k) {
      const std::size_t path = index_of(group.frames.keys[k]);
      if (path >= paths.size() || paths[path].nodes().empty()) continue;
      if (members.empty()) {
        T_map_ref = (group.frames.T_ref_odom[k].se3() * T_level_map(paths[path])).inverse();
      } else {
        out.decided_by[path] = group.by[k];
      }
      out.T_map_odom[path] =
          T_map_ref * group.frames.T_ref_odom[k].se3() * T_level_odom(paths[path]);
      members.push_back(path);
    }
    if (!members.empty()) out.groups.push_back(members);
  }
  std::stable_sort(out.groups.begin(), out.groups.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  for (std::size_t g = 0; g < out.groups.size(); ++g) {
    for (const std::size_t path : out.groups[g]) out.group[path] = g;
  }
  return out;
}

}  // namespace rali::fleet
