#include "rali/places/planes.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "rali/cloud/voxel_sampler.hpp"
#include "rali/geometry/pca3.hpp"

namespace rali::places {

using geometry::Mat3;
using geometry::Vec3;
using geometry::Vec3f;

namespace {

constexpr int kLevels = 4;

enum class Fit { kPlane, kTooFew, kTooThick };

/// Moments of the points of a cell, relative to its centre.
struct Moments {
  int n = 0;
  Vec3 mean = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
  Mat3 rays = Mat3::Zero();  ///< mean of ray ray^T
  Vec3 ray = Vec3::Zero();   ///< mean
};

class Builder {
 public:
  Builder(std::span<const Vec3f> points, std::span<const Vec3f> rays, const PlaneSettings& settings)
      : points_(points), rays_(rays), settings_(settings) {}

  std::vector<Plane> build();

 private:
  using Indices = std::span<std::uint32_t>;

  Moments moments(Indices indices, const Vec3& center) const;
  Fit fit(const Moments& m, const Vec3& center, int level, Plane& plane) const;
  void divide(Indices indices, const Vec3& center, int level);

  std::span<const Vec3f> points_, rays_;
  const PlaneSettings& settings_;
  std::vector<std::uint32_t> scratch_;
  std::vector<Plane> planes_;
};

Moments Builder::moments(Indices indices, const Vec3& center) const {
  Moments m;
  m.n = static_cast<int>(indices.size());
  Mat3 square = Mat3::Zero();
  for (const std::uint32_t i : indices) {
    const Vec3 p = points_[i].cast<double>() - center;
    const Vec3 ray = rays_[i].cast<double>();
    m.mean += p;
    m.ray += ray;
    square.noalias() += p * p.transpose();
    m.rays.noalias() += ray * ray.transpose();
  }
  const double inverse = 1.0 / m.n;
  m.mean *= inverse;
  m.ray *= inverse;
  m.rays *= inverse;
  m.covariance = inverse * square - m.mean * m.mean.transpose();
  return m;
}

Fit Builder::fit(const Moments& m, const Vec3& center, int level, Plane& plane) const {
  const bool finest = level + 1 == kLevels;
  const double edge_m = settings_.cell_m / (1 << level);
  // Range noise lies along the rays. It is subtracted before the axes are computed, or one ring on
  // a floor would spread along the ray like a narrow plane and give a false one.
  const double range_var = settings_.range_sigma_m * settings_.range_sigma_m;
  const geometry::Pca3 pca = geometry::pca3(m.covariance - range_var * m.rays);
  Vec3 n = pca.vectors.col(2);
  const double excess = finest ? settings_.excess_max_finest_m : settings_.excess_max_m;
  if (pca.values[2] > excess * excess) return Fit::kTooThick;
  const double width = settings_.width_min_ratio * edge_m;
  if (pca.values[1] < width * width) return Fit::kTooFew;
  const double l3 = std::max(0.0, n.dot(m.covariance * n));
  if (pca.values[1] < 4.0 * l3) return finest ? Fit::kTooFew : Fit::kTooThick;
  if (n.dot(m.ray) > 0.0) n = -n;
  const double s2 =
      std::max(settings_.sigma_floor_m * settings_.sigma_floor_m, l3 * m.n / (m.n - 3.0));
  const double between = settings_.sigma_between_m * settings_.sigma_between_m;
  plane.q_m = center + m.mean;
  plane.n = n;
  plane.e1 = pca.vectors.col(0);
  plane.e2 = pca.vectors.col(1);
  plane.var_noise = s2 / m.n + between;
  plane.var_tilt1 = plane.var_noise / pca.values[0];
  plane.var_tilt2 = plane.var_noise / pca.values[1];
  plane.var_offset = s2 / m.n + settings_.sigma_systematic_m * settings_.sigma_systematic_m;
  plane.radius_m = 0.87 * edge_m;
  plane.points = m.n;
  return Fit::kPlane;
}

void Builder::divide(Indices indices, const Vec3& center, int level) {
  if (static_cast<int>(indices.size()) < settings_.points_min) return;
  Plane plane;
  const Fit result = fit(moments(indices, center), center, level, plane);
  if (result == Fit::kPlane) planes_.push_back(plane);
  if (result != Fit::kTooThick || level + 1 == kLevels) return;
  const auto octant = [&](std::uint32_t i) {
    const Vec3 p = points_[i].cast<double>();
    return (p.x() >= center.x() ? 1U : 0U) | (p.y() >= center.y() ? 2U : 0U) |
           (p.z() >= center.z() ? 4U : 0U);
  };
  std::array<std::uint32_t, 9> begin{};
  for (const std::uint32_t i : indices) ++begin[octant(i) + 1];
  for (std::size_t k = 0; k < 8; ++k) begin[k + 1] += begin[k];
  scratch_.assign(indices.begin(), indices.end());
  std::array<std::uint32_t, 8> next{};
  std::copy_n(begin.begin(), 8, next.begin());
  for (const std::uint32_t i : scratch_) indices[next[octant(i)]++] = i;
  const double q = 0.25 * settings_.cell_m / (1 << level);
  for (std::size_t k = 0; k < 8; ++k) {
    const Vec3 child = center + Vec3((k & 1U) ? q : -q, (k & 2U) ? q : -q, (k & 4U) ? q : -q);
    divide(indices.subspan(begin[k], begin[k + 1] - begin[k]), child, level + 1);
  }
}

std::vector<Plane> Builder::build() {
  const double inverse = 1.0 / settings_.cell_m;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order(points_.size());
  for (std::uint32_t i = 0; i < points_.size(); ++i) {
    const Vec3 c = points_[i].cast<double>() * inverse;
    order[i] = {cloud::voxel_key(cloud::floor_to_int(c.x()), cloud::floor_to_int(c.y()),
                                 cloud::floor_to_int(c.z())),
                i};
  }
  std::sort(order.begin(), order.end());
  std::vector<std::uint32_t> indices(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) indices[k] = order[k].second;
  for (std::size_t b = 0; b < order.size();) {
    std::size_t e = b + 1;
    while (e < order.size() && order[e].first == order[b].first) ++e;
    const Vec3 c = points_[indices[b]].cast<double>() * inverse;
    const Vec3 center(cloud::floor_to_int(c.x()) + 0.5, cloud::floor_to_int(c.y()) + 0.5,
                      cloud::floor_to_int(c.z()) + 0.5);
    divide(Indices(indices).subspan(b, e - b), settings_.cell_m * center, 0);
    b = e;
  }
  return std::move(planes_);
}

}  // namespace

std::vector<Plane> planes_of(std::span<const Vec3f> points, std::span<const Vec3f> rays,
                             const PlaneSettings& settings) {
  return Builder(points, rays, settings).build();
}

}  // namespace rali::places
