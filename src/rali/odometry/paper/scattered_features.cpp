#include "rali/odometry/paper/scattered_features.hpp"

#include <cmath>

#include "rali/geometry/pca3.hpp"

namespace rali::odometry::paper {

using geometry::Mat3;
using geometry::Vec3;
using geometry::Vec3f;

namespace {

constexpr int kNeighboursMin = 6;
constexpr double kLineRatioMax = 0.1;    // second to first eigenvalue: below, it is a line
constexpr double kThickRatioMax = 0.02;  // third to second eigenvalue: above, it is no plane

bool plane_normal(const PointGrid& grid, const Vec3f& query, Vec3& n) {
  Vec3 sum = Vec3::Zero();
  Mat3 squares = Mat3::Zero();
  int count = 0;
  grid.for_each_within(query, [&](const PointNormal& neighbour) {
    const Vec3 d = (neighbour.p - query).cast<double>();
    sum += d;
    squares += d * d.transpose();
    ++count;
  });
  if (count < kNeighboursMin) return false;
  const Vec3 mean = sum / count;
  const geometry::Pca3 pca = geometry::pca3(squares / count - mean * mean.transpose());
  if (pca.values(1) < kLineRatioMax * pca.values(0)) return false;
  if (pca.values(2) > kThickRatioMax * pca.values(1)) return false;
  n = pca.vectors.col(2);
  return n.allFinite();
}

}  // namespace

void ScatteredFeatureExtractor::extract(const PointsView& points,
                                        std::span<const std::uint32_t> candidates,
                                        const PlanarFeatureSettings& settings,
                                        PlanarFeatures& out) {
  out.clear();
  thinned_.clear();
  for (const std::uint32_t i : candidates) {
    thinned_.push_back({Vec3f(points.x_m[i], points.y_m[i], points.z_m[i]), Vec3f::Zero()});
  }
  grid_.build(thinned_, static_cast<float>(3.0 * settings.downsample_m));
  for (const PointNormal& candidate : thinned_) {
    Vec3 n;
    if (!plane_normal(grid_, candidate.p, n)) continue;
    const bool away = n.dot(candidate.p.cast<double>()) > 0.0;
    const Vec3f to_sensor = (away ? Vec3(-n) : n).cast<float>();
    out.x_m.push_back(candidate.p.x());
    out.y_m.push_back(candidate.p.y());
    out.z_m.push_back(candidate.p.z());
    out.nx.push_back(to_sensor.x());
    out.ny.push_back(to_sensor.y());
    out.nz.push_back(to_sensor.z());
    out.turned.push_back(away ? 1 : 0);
  }
}

}  // namespace rali::odometry::paper
