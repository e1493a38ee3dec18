#include "rali/sim/route.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rali/base/assert.hpp"

namespace rali::sim {

using geometry::Vec3;

namespace {

/// Mean over +-half samples; beyond the ends the values are mirrored through the end point, so
/// the ends keep their values.
std::vector<double> box_filtered(const std::vector<double>& v, int half) {
  const int n = static_cast<int>(v.size());
  const auto value = [&](int i) {
    if (i < 0) return 2.0 * v.front() - v[static_cast<std::size_t>(std::min(-i, n - 1))];
    if (i >= n) return 2.0 * v.back() - v[static_cast<std::size_t>(std::max(2 * n - 2 - i, 0))];
    return v[static_cast<std::size_t>(i)];
  };
  std::vector<double> out(v.size());
  double sum = 0.0;
  for (int i = -half; i <= half; ++i) sum += value(i);
  for (int i = 0; i < n; ++i) {
    out[static_cast<std::size_t>(i)] = sum / (2 * half + 1);
    sum += value(i + half + 1) - value(i - half);
  }
  return out;
}

void smooth(std::vector<double>& v, double rounding_m) {
  // Three box filters approximate a Gaussian: curvature changes smoothly, as wheels can follow.
  const int half = std::max(1, static_cast<int>(rounding_m / Route::kStep_m / 2.0));
  for (int pass = 0; pass < 3; ++pass) v = box_filtered(v, half);
}

}  // namespace

Route::Route(const std::vector<Vec3>& corners, double rounding_m) {
  RALI_ASSERT(corners.size() >= 2);
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Vec3 step = corners[i] - corners[i - 1];
    const int n = std::max(1, static_cast<int>(std::ceil(step.norm() / kStep_m)));
    for (int k = (i == 1 ? 0 : 1); k <= n; ++k) {
      const Vec3 p = corners[i - 1] + step * (static_cast<double>(k) / n);
      x_.push_back(p.x());
      y_.push_back(p.y());
      z_.push_back(p.z());
    }
  }
  smooth(x_, rounding_m);
  smooth(y_, rounding_m);
  smooth(z_, rounding_m);
  s_m_.assign(x_.size(), 0.0);
  yaw_.assign(x_.size(), 0.0);
  slope_.assign(x_.size(), 0.0);
  for (std::size_t i = 1; i < x_.size(); ++i) {
    const double dx = x_[i] - x_[i - 1];
    const double dy = y_[i] - y_[i - 1];
    const double flat = std::hypot(dx, dy);
    s_m_[i] = s_m_[i - 1] + flat;
    slope_[i] = flat > 0.0 ? (z_[i] - z_[i - 1]) / flat : 0.0;
    const double yaw = std::atan2(dy, dx);
    if (i == 1) {
      yaw_[0] = yaw;
      slope_[0] = slope_[1];
    }
    yaw_[i] = yaw_[i - 1] + std::remainder(yaw - yaw_[i - 1], 2.0 * std::numbers::pi);
  }
  smooth(yaw_, 0.2);
  smooth(slope_, 0.6);
}

double Route::sample(const std::vector<double>& values, double s_m) const {
  const auto after = std::upper_bound(s_m_.begin(), s_m_.end(), s_m);
  if (after == s_m_.begin()) return values.front();
  if (after == s_m_.end()) return values.back();
  const auto i = static_cast<std::size_t>(after - s_m_.begin());
  const double span = s_m_[i] - s_m_[i - 1];
  const double u = span > 0.0 ? (s_m - s_m_[i - 1]) / span : 0.0;
  return values[i - 1] + u * (values[i] - values[i - 1]);
}

Vec3 Route::point_at(double s_m) const {
  return {sample(x_, s_m), sample(y_, s_m), sample(z_, s_m)};
}

double Route::yaw_at(double s_m) const { return sample(yaw_, s_m); }

double Route::slope_at(double s_m) const { return sample(slope_, s_m); }

double Route::curvature_at(double s_m) const {
  constexpr double kHalf_m = 0.1;
  return (yaw_at(s_m + kHalf_m) - yaw_at(s_m - kHalf_m)) / (2.0 * kHalf_m);
}

}  // namespace rali::sim
