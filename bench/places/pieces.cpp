#include "pieces.hpp"

#include <algorithm>

#include "common/cpu_time.hpp"

namespace rali::recognition {

using geometry::SE3;

namespace {

places::PosedScan posed(const Kept& k) {
  places::PosedScan out;
  out.scan.id = k.id;
  out.scan.T_body_lidar = k.T_body_lidar;
  out.scan.up_body = k.up_body;
  out.scan.x_m = k.x_m;
  out.scan.y_m = k.y_m;
  out.scan.z_m = k.z_m;
  out.T_odom_body = k.T_odom_body;
  return out;
}

/// One vehicle's keyframes about `spacing_m` apart, with the path length up to each.
struct Path {
  std::vector<const Kept*> keyframes;
  std::vector<double> path_m;
};

std::vector<Path> paths_of(const std::vector<Kept>& keyframes, double spacing_m) {
  std::vector<Path> out;
  for (const Kept& k : keyframes) {
    const std::size_t v = k.id.vehicle.value;
    if (out.size() <= v) out.resize(v + 1);
    Path& path = out[v];
    double distance_m = 0.0;
    if (!path.keyframes.empty()) {
      const double step = (k.T_odom_body.p - path.keyframes.back()->T_odom_body.p).norm();
      if (step < spacing_m) continue;
      distance_m = path.path_m.back() + step;
    }
    path.keyframes.push_back(&k);
    path.path_m.push_back(distance_m);
  }
  return out;
}

Result<Piece> piece_around(const Path& path, std::size_t middle, const PieceOptions& o,
                           const places::PlacesSettings& settings) {
  std::vector<places::PosedScan> scans;
  std::size_t at = 0;
  for (std::size_t k = 0; k < path.keyframes.size(); ++k) {
    if (std::abs(path.path_m[k] - path.path_m[middle]) > 0.5 * o.length_m) continue;
    if (k == middle) at = scans.size();
    scans.push_back(posed(*path.keyframes[k]));
  }
  const double begin = bench::cpu_ms();
  auto submap = places::make_submap(scans, at, settings.submap);
  if (!submap) return tl::make_unexpected(submap.error());
  Piece out;
  out.submap = std::move(*submap);
  const double made = bench::cpu_ms();
  out.descriptor = places::describe(out.submap, settings.descriptor);
  out.make_ms = made - begin;
  out.describe_ms = bench::cpu_ms() - made;
  out.T_world_ref = path.keyframes[middle]->T_world_body * out.submap.T_ref_body().inverse();
  return out;
}

}  // namespace

Result<std::vector<Piece>> cut(const std::vector<Kept>& keyframes, const PieceOptions& o,
                               const places::PlacesSettings& settings) {
  std::vector<Piece> out;
  for (const Path& path : paths_of(keyframes, o.scan_every_m)) {
    double next_m = 0.5 * o.length_m;
    for (std::size_t k = 0; k < path.keyframes.size(); ++k) {
      if (path.path_m[k] < next_m || path.path_m[k] + 0.5 * o.length_m > path.path_m.back())
        continue;
      next_m = path.path_m[k] + o.every_m;
      auto piece = piece_around(path, k, o, settings);
      if (!piece) return tl::make_unexpected(piece.error());
      out.push_back(std::move(*piece));
    }
  }
  return out;
}

bool share_scans(const Piece& a, const Piece& b) {
  return std::any_of(a.submap.scans().begin(), a.submap.scans().end(), [&](KeyframeId id) {
    return std::find(b.submap.scans().begin(), b.submap.scans().end(), id) !=
           b.submap.scans().end();
  });
}

}  // namespace rali::recognition
