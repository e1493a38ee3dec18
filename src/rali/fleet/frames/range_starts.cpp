#include "rali/fleet/frames/range_starts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "rali/geometry/robust.hpp"

namespace rali::fleet {

using geometry::Vec2;

namespace {

/// Singular values below this fraction of the largest are truncated (algorithms_fleet 7.4, step 1).
constexpr double kSingular = 1e-3;
constexpr double kMinDistance_m = 1e-3;
/// Solutions much worse than the best cannot become the best by refinement.
constexpr std::size_t kKept = 16;

Vec2 turned(double c, double s, const Vec2& v) {
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}

/// Gauss-Newton in (yaw, t, bias).
class PlanarSolver {
 public:
  using Vector = Eigen::Vector4d;
  using Matrix = Eigen::Matrix4d;

  PlanarSolver(const std::vector<PlanarRange>& ranges, bool yaw_fixed, const InitSettings& settings)
      : ranges_(ranges), settings_(settings), yaw_fixed_(yaw_fixed) {}

  [[nodiscard]] PlanarSolution refine(double yaw_rad, const Vec2& t_m) const {
    Vector v(yaw_rad, t_m.x(), t_m.y(), 0.0);
    Matrix H, H_tried;
    Vector g, g_tried;
    double cost = build(v, H, g);
    double lambda = 1e-3;
    for (int k = 0; k < settings_.search.iterations; ++k) {
      Matrix damped = H;
      damped.diagonal() *= 1.0 + lambda;
      damped.diagonal().array() += 1e-6;
      const Vector tried = v - damped.ldlt().solve(g);
      const double cost_tried = build(tried, H_tried, g_tried);
      if (cost_tried <= cost) {
        const bool done = cost - cost_tried < 1e-5 * (1.0 + 1e-2 * cost);
        v = tried;
        cost = cost_tried;
        H = H_tried;
        g = g_tried;
        lambda = std::max(1e-9, 0.1 * lambda);
        if (done) break;
      } else {
        lambda *= 10.0;
        if (!(lambda < 1e8)) break;
      }
    }
    return {wrapped(v[0]), v.segment<2>(1), cost};
  }

 private:
  double build(const Vector& v, Matrix& H, Vector& g) const {
    H.setZero();
    g.setZero();
    double cost = 0.0;
    if (settings_.bias_sigma_m > 0.0) {
      H(3, 3) = 1.0 / (settings_.bias_sigma_m * settings_.bias_sigma_m);
      g[3] = H(3, 3) * v[3];
      cost = g[3] * v[3];
    }
    const double knee = settings_.search.huber;
    const double c = std::cos(v[0]);
    const double s = std::sin(v[0]);
    for (const PlanarRange& r : ranges_) {
      const Vec2 x = turned(c, s, r.x_m);
      const Vec2 apart = x + v.segment<2>(1) - r.y_m;
      const double rho = std::max(apart.norm(), kMinDistance_m);
      const Vec2 u = apart / rho;
      const double e = (rho + v[3] - r.range_m) / r.sigma_m;
      const double yaw = yaw_fixed_ ? 0.0 : u.y() * x.x() - u.x() * x.y();
      const double bias = settings_.bias_sigma_m > 0.0 ? 1.0 : 0.0;
      const Vector J = Vector(yaw, u.x(), u.y(), bias) / r.sigma_m;
      const double weight = geometry::huber_weight(e, knee);
      H.noalias() += weight * J * J.transpose();
      g += weight * e * J;
      cost += std::abs(e) <= knee ? e * e : 2.0 * knee * std::abs(e) - knee * knee;
    }
    return cost;
  }

  const std::vector<PlanarRange>& ranges_;
  const InitSettings& settings_;
  bool yaw_fixed_;
};

/// Evenly spaced samples, at most `maximum`.
std::vector<PlanarRange> thinned(const std::vector<PlanarRange>& ranges, int maximum) {
  const auto limit = static_cast<std::size_t>(maximum);
  if (ranges.size() <= limit) return ranges;
  std::vector<PlanarRange> out;
  for (std::size_t k = 0; k < limit; ++k) {
    out.push_back(ranges[k * (ranges.size() - 1) / (limit - 1)]);
  }
  return out;
}

}  // namespace

LinearStart linear_start(const std::vector<PlanarRange>& ranges, double yaw_rad) {
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  const auto n = static_cast<double>(ranges.size());
  std::vector<Vec2> z;
  LinearStart out;
  for (const PlanarRange& r : ranges) {
    z.push_back(turned(c, s, r.x_m) - r.y_m);
    out.mean_m += z.back() / n;
  }
  // About the mean the unknown |t|^2 separates from t.
  Eigen::Matrix2d M = Eigen::Matrix2d::Zero();
  Vec2 right = Vec2::Zero();
  double square = 0.0;
  for (std::size_t k = 0; k < z.size(); ++k) {
    const Vec2 d = z[k] - out.mean_m;
    const double difference = ranges[k].range_m * ranges[k].range_m - d.squaredNorm();
    M += 4.0 * d * d.transpose();
    right += 2.0 * difference * d;
    square += difference / n;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(M);
  const Vec2 values = solver.eigenvalues();
  out.along = solver.eigenvectors().col(1);
  Vec2 about_mean = Vec2::Zero();
  for (int k = 0; k < 2; ++k) {
    const bool cut = !(std::sqrt(std::max(0.0, values[k])) > kSingular * std::sqrt(values[1]));
    if (cut || !(values[k] > 0.0)) continue;
    const Vec2 axis = solver.eigenvectors().col(k);
    about_mean += axis.dot(right) / values[k] * axis;
  }
  out.t_m = about_mean - out.mean_m;
  // |t + mean|^2 was solved; converted to |t|^2 of the equations at the origin.
  out.square_m2 = square - 2.0 * about_mean.dot(out.mean_m) + out.mean_m.squaredNorm();
  return out;
}

std::vector<Vec2> planar_starts(const std::vector<PlanarRange>& ranges, double yaw_rad) {
  const LinearStart start = linear_start(ranges, yaw_rad);
  const Vec2 normal(-start.along.y(), start.along.x());
  const Vec2 about_mean = start.t_m + start.mean_m;
  const double c = -about_mean.dot(start.along);
  double h2 = 0.0;
  const double cos_yaw = std::cos(yaw_rad);
  const double sin_yaw = std::sin(yaw_rad);
  for (const PlanarRange& r : ranges) {
    const Vec2 z = turned(cos_yaw, sin_yaw, r.x_m) - r.y_m - start.mean_m;
    const double along = z.dot(start.along) - c;
    h2 += (r.range_m * r.range_m - along * along) / static_cast<double>(ranges.size());
  }
  std::vector<Vec2> out;
  // On the line itself the gradients of both sides cancel: descent from there finds neither.
  const double across_m = about_mean.dot(normal);
  if (std::abs(across_m) > kMinDistance_m || !(h2 > 0.0)) {
    out = {start.t_m, start.t_m - 2.0 * across_m * normal};
  }
  if (h2 > 0.0) {
    const double h = std::sqrt(h2);
    out.push_back(-(start.mean_m + c * start.along + h * normal));
    out.push_back(-(start.mean_m + c * start.along - h * normal));
  }
  return out;
}

std::vector<PlanarSolution> search_plane(const std::vector<PlanarRange>& all, bool yaw_fixed,
                                         const InitSettings& settings) {
  std::vector<PlanarSolution> out;
  if (all.empty()) return out;
  const std::vector<PlanarRange> ranges = thinned(all, settings.search.samples_max);
  const PlanarSolver solver(ranges, yaw_fixed, settings);
  const Vec2 pivot = ranges.front().x_m;
  const auto place = [&](const PlanarSolution& p) {
    return Vec2(turned(std::cos(p.yaw_rad), std::sin(p.yaw_rad), pivot) + p.t_m);
  };
  const int headings =
      yaw_fixed ? 1 : static_cast<int>(std::ceil(360.0 / settings.search.yaw_step_deg));
  for (int k = 0; k < headings; ++k) {
    const double yaw_rad = 2.0 * std::numbers::pi * k / headings;
    for (const Vec2& t : planar_starts(ranges, yaw_rad)) {
      const PlanarSolution s = solver.refine(yaw_rad, t);
      if (!std::isfinite(s.chi2) || !s.t_m.allFinite()) continue;
      const auto same = std::find_if(out.begin(), out.end(), [&](const PlanarSolution& o) {
        return one_place((place(o) - place(s)).norm(), wrapped(o.yaw_rad - s.yaw_rad),
                         settings.search, 0.5);
      });
      if (same == out.end()) {
        out.push_back(s);
      } else if (s.chi2 < same->chi2) {
        *same = s;
      }
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const PlanarSolution& a, const PlanarSolution& b) {
    return a.chi2 < b.chi2;
  });
  if (out.size() > kKept) out.resize(kKept);
  return out;
}

}  // namespace rali::fleet
