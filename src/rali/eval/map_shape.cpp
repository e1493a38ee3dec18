#include "rali/eval/map_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "rali/geometry/pca3.hpp"

namespace rali::eval {

using geometry::Mat3;
using geometry::Vec3;

namespace {

constexpr std::size_t kBlock = 1024;
// A plane without thickness has entropy minus infinity; variances are at least (1 micrometre)^2.
constexpr double kVarianceMin_m2 = 1e-12;

/// Sums about a given centre avoid the subtraction of large numbers.
class Spread {
 public:
  void add(const Vec3& offset) {
    sum_ += offset;
    square_ += offset * offset.transpose();
    ++n_;
  }

  [[nodiscard]] std::size_t size() const { return n_; }

  [[nodiscard]] PatchShape shape() const {
    const double n = static_cast<double>(n_);
    const Vec3 mean = sum_ / n;
    const Mat3 C = square_ / n - mean * mean.transpose();
    const Vec3 values = geometry::pca3(C).values.cwiseMax(kVarianceMin_m2);
    const double ln_det = std::log(values[0]) + std::log(values[1]) + std::log(values[2]);
    return {std::sqrt(values[2]), values[2] / values[1],
            0.5 * (3.0 * std::log(2.0 * std::numbers::pi * std::numbers::e) + ln_det)};
  }

 private:
  Vec3 sum_ = Vec3::Zero();
  Mat3 square_ = Mat3::Zero();
  std::size_t n_ = 0;
};

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Thickness and entropy of the neighbourhood of each point; NaN where there are too few points.
struct PointShapes {
  std::vector<double> thickness_m, entropy;
};

PointShapes shapes_of(const PointList& points, const MapShapeOptions& o, Executor& executor) {
  PointShapes out{std::vector<double>(points.size(), kNone),
                  std::vector<double>(points.size(), kNone)};
  const PointGrid grid(points, std::max(o.entropy_radius_m, o.patch_radius_m));
  const double entropy2 = o.entropy_radius_m * o.entropy_radius_m;
  const double patch2 = o.patch_radius_m * o.patch_radius_m;
  const auto one = [&](std::size_t i) {
    Spread patch, ball;
    grid.for_each_near(points[i], [&](std::uint32_t j, double d2) {
      const Vec3 offset = points[j] - points[i];
      if (d2 <= patch2) patch.add(offset);
      if (d2 <= entropy2) ball.add(offset);
      return true;
    });
    if (ball.size() > o.neighbours_min) out.entropy[i] = ball.shape().entropy;
    if (patch.size() <= o.neighbours_min) return;
    const PatchShape shape = patch.shape();
    if (shape.flatness < o.flatness_max) out.thickness_m[i] = shape.thickness_m;
  };
  executor.for_blocks(points.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) one(i);
  });
  return out;
}

std::vector<double> known(const std::vector<double>& values) {
  std::vector<double> out;
  for (const double v : values) {
    if (!std::isnan(v)) out.push_back(v);
  }
  return out;
}

}  // namespace

PatchShape patch_shape(std::span<const Vec3> points) {
  Spread spread;
  for (const Vec3& p : points) spread.add(p - points.front());
  return spread.shape();
}

MapShape map_shape(const PointList& points, const MapShapeOptions& options, Executor& executor) {
  PointList kept;
  if (options.thin_m > 0.0) {
    kept = thinned(points, options.thin_m);
  } else {
    std::copy_if(points.begin(), points.end(), std::back_inserter(kept),
                 [](const Vec3& p) { return p.allFinite(); });
  }
  MapShape out;
  out.points = kept.size();
  if (kept.empty()) return out;
  const PointShapes shapes = shapes_of(kept, options, executor);
  const std::vector<double> thickness = known(shapes.thickness_m);
  out.patches = thickness.size();
  out.thickness_p95_m = quantile(thickness, 0.95);
  out.thickness = statistics(thickness);
  const std::vector<double> entropy = known(shapes.entropy);
  out.entropy_points = entropy.size();
  if (!entropy.empty()) out.mme = statistics(entropy).mean;
  return out;
}

}  // namespace rali::eval
