#include "rali/fleet/centre/path_submaps.hpp"

#include <algorithm>
#include <deque>
#include <optional>

namespace rali::fleet {

using geometry::SE3;
using geometry::Vec3;

namespace {

/// A keyframe with points, and its distance along the path.
struct Stop {
  std::size_t node = 0;
  double path_m = 0.0;
  const KeyframePoints* points = nullptr;
};

/// Content of one submap; indices of stops.
struct Cut {
  std::size_t path = 0;
  std::size_t first = 0, last = 0, middle = 0;
};

/// One list per map of the path: a new one begins where the vehicle lost the old one. A leap counts
/// at most as one piece: no piece spans it, and a leap of a million metres needs no empty pieces.
std::vector<std::vector<Stop>> stops_of(const VehiclePath& path, std::size_t begin, double leap_m) {
  std::vector<std::vector<Stop>> parts(1);
  double path_m = 0.0;
  const auto& nodes = path.nodes();
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Increment& step = *nodes[k].step;
    if (k > 0 && !step.begins) {
      path_m += std::min(leap_m, (step.T_odom_body.p - nodes[k - 1].step->T_odom_body.p).norm());
    }
    if (step.begins && !parts.back().empty()) parts.emplace_back();
    if (!step.keyframe || k < begin) continue;
    const auto points = path.points().find(*step.keyframe);
    if (points == path.points().end() || points->second.size() == 0) continue;
    parts.back().push_back({k, path_m, &points->second});
  }
  std::erase_if(parts, [](const std::vector<Stop>& part) { return part.empty(); });
  return parts;
}

/// Pieces of a given length at given steps; the last one reaches to the end.
std::vector<Cut> cuts_of(const std::vector<Stop>& stops, std::size_t path, const CutSettings& cut) {
  std::vector<Cut> cuts;
  const double end_m = stops.back().path_m;
  for (double at_m = stops.front().path_m;; at_m += cut.step_m) {
    const double start_m = std::max(stops.front().path_m, std::min(at_m, end_m - cut.length_m));
    Cut c;
    c.path = path;
    while (c.first + 1 < stops.size() && stops[c.first].path_m < start_m) ++c.first;
    c.last = c.first;
    while (c.last + 1 < stops.size() && stops[c.last + 1].path_m <= start_m + cut.length_m)
      ++c.last;
    const double middle_m = 0.5 * (stops[c.first].path_m + stops[c.last].path_m);
    c.middle = c.first;
    while (c.middle < c.last && stops[c.middle].path_m < middle_m) ++c.middle;
    cuts.push_back(c);
    if (start_m + cut.length_m >= end_m) break;
  }
  return cuts;
}

std::optional<PathSubmap> make(const VehiclePath& path, const std::vector<Stop>& stops,
                               const Cut& cut, int scans_max,
                               const places::PlacesSettings& settings) {
  const Vec3 up_odom = path.up_odom();
  std::vector<places::PosedScan> scans;
  std::deque<PointArrays> arrays;  // does not move what the scans refer to
  std::size_t middle = 0;
  const std::size_t n = cut.last - cut.first + 1;
  const std::size_t every =
      (n + static_cast<std::size_t>(scans_max) - 1) / static_cast<std::size_t>(scans_max);
  for (std::size_t i = cut.first; i <= cut.last; ++i) {
    if (i != cut.middle && (i - cut.first) % every != 0) continue;
    if (i == cut.middle) middle = scans.size();
    const Increment& step = *path.nodes()[stops[i].node].step;
    const KeyframePoints& points = *stops[i].points;
    places::PosedScan scan;
    scan.T_odom_body = step.T_odom_body;
    scan.scan.id = {path.vehicle(), points.keyframe};
    scan.scan.T_body_lidar = points.T_body_lidar;
    scan.scan.up_body = (step.T_odom_body.R.transpose() * up_odom).normalized();
    const PointArrays& seen = arrays.emplace_back(points.points.unpacked());
    scan.scan.x_m = seen.x_m;
    scan.scan.y_m = seen.y_m;
    scan.scan.z_m = seen.z_m;
    scans.push_back(scan);
  }
  Result<places::Submap> submap = places::make_submap(scans, middle, settings.submap);
  if (!submap) return std::nullopt;
  PathSubmap out;
  out.path = cut.path;
  out.node = stops[cut.middle].node;
  out.path_m = stops[cut.middle].path_m;
  out.T_odom_ref = scans[middle].T_odom_body * submap->T_ref_body().inverse();
  out.descriptor = places::describe(*submap, settings.descriptor);
  out.submap = std::move(*submap);
  return out;
}

}  // namespace

std::vector<PathSubmap> cut_into_submaps(std::span<const VehiclePath> paths, const CutSettings& cut,
                                         const places::PlacesSettings& places, Executor& executor,
                                         std::span<const std::size_t> begins, StopFlag stop) {
  struct Job {
    const std::vector<Stop>* stops = nullptr;
    Cut cut;
  };

  std::vector<std::vector<std::vector<Stop>>> stops;
  for (std::size_t p = 0; p < paths.size(); ++p) {
    stops.push_back(stops_of(paths[p], begins.empty() ? 0 : begins[p], cut.length_m));
  }
  std::vector<Job> jobs;
  for (std::size_t p = 0; p < paths.size(); ++p) {
    for (const std::vector<Stop>& part : stops[p]) {
      for (const Cut& c : cuts_of(part, p, cut)) jobs.push_back({&part, c});
    }
  }
  std::vector<std::optional<PathSubmap>> made(jobs.size());
  executor.for_blocks(jobs.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
    if (stop.raised()) return;
    made[i] = make(paths[jobs[i].cut.path], *jobs[i].stops, jobs[i].cut, cut.scans_max, places);
  });
  std::vector<PathSubmap> submaps;
  for (std::optional<PathSubmap>& submap : made) {
    if (submap) submaps.push_back(std::move(*submap));
  }
  return submaps;
}

}  // namespace rali::fleet
