#include "rali/eval/cloud_to_mesh.hpp"

#include <algorithm>
#include <utility>

namespace rali::eval {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr std::size_t kBlock = 4096;
constexpr std::size_t kSamplesMax = 2'000'000;

double completeness(const std::vector<Vec3>& samples, const PointList& points, double radius_m,
                    Executor& executor) {
  if (samples.empty() || points.empty()) return 0.0;
  const PointGrid grid(points, radius_m);
  std::vector<std::size_t> seen((samples.size() + kBlock - 1) / kBlock, 0);
  executor.for_blocks(samples.size(), kBlock,
                      [&](std::size_t block, std::size_t begin, std::size_t end) {
                        for (std::size_t i = begin; i < end; ++i) {
                          grid.for_each_near(samples[i], [&](std::uint32_t, double) {
                            ++seen[block];
                            return false;
                          });
                        }
                      });
  std::size_t total = 0;
  for (const std::size_t n : seen) total += n;
  return static_cast<double>(total) / static_cast<double>(samples.size());
}

}  // namespace

std::vector<double> distances_to_mesh(const PointList& points, const TriangleTree& tree,
                                      Executor& executor) {
  std::vector<double> out(points.size(), 0.0);
  executor.for_blocks(points.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      out[i] = tree.nearest(points[i]).distance_m;
    }
  });
  return out;
}

CloudToMesh cloud_to_mesh(const PointList& points, const SE3& T_mesh_cloud,
                          const TriangleMesh& mesh, const TriangleTree& tree,
                          const CloudToMeshOptions& options, Executor& executor) {
  CloudToMesh out;
  PointList kept;
  for (const Vec3& p : points) {
    if (p.allFinite()) kept.push_back(p);
  }
  out.not_finite = points.size() - kept.size();
  if (options.thin_m > 0.0) kept = thinned(kept, options.thin_m);
  for (Vec3& p : kept) p = T_mesh_cloud * p;
  std::vector<double> distances = distances_to_mesh(kept, tree, executor);
  out.all = statistics(distances);
  std::vector<double> within;
  for (const double d : distances) {
    if (d <= options.cut_m) within.push_back(d);
  }
  out.beyond = distances.size() - within.size();
  if (!distances.empty()) {
    out.fraction_beyond = static_cast<double>(out.beyond) / static_cast<double>(distances.size());
  }
  out.p95_m = quantile(within, 0.95);
  out.within = statistics(std::move(within));
  const std::vector<Vec3> samples = sample_surface(mesh, options.sample_spacing_m, kSamplesMax);
  out.samples = samples.size();
  out.completeness = completeness(samples, kept, options.complete_m, executor);
  return out;
}

}  // namespace rali::eval
