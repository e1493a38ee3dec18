#include "drive.hpp"

#include <algorithm>
#include <cmath>

namespace rali::frames_bench {

using geometry::Vec2;
using geometry::Vec3;

std::vector<Vec2> way_through(const std::vector<Vec2>& corners, std::size_t n) {
  std::vector<double> at_m = {0.0};
  for (std::size_t k = 1; k < corners.size(); ++k) {
    at_m.push_back(at_m.back() + (corners[k] - corners[k - 1]).norm());
  }
  std::vector<Vec2> out;
  std::size_t leg = 1;
  for (std::size_t i = 0; i < n; ++i) {
    if (corners.size() == 1) {
      out.push_back(corners.front());
      continue;
    }
    const double s = at_m.back() * static_cast<double>(i) / static_cast<double>(n - 1);
    while (leg + 1 < corners.size() && at_m[leg] < s) ++leg;
    const double fraction = (s - at_m[leg - 1]) / std::max(1e-9, at_m[leg] - at_m[leg - 1]);
    out.push_back(corners[leg - 1] + fraction * (corners[leg] - corners[leg - 1]));
  }
  return out;
}

Drive drive_along(const std::vector<Vec2>& path, const DriveErrors& errors, Rng& rng) {
  Drive out;
  out.true_m = path;
  out.odom_m = {path.front()};
  const double scale = 1.0 + errors.scale * rng.normal();
  double yaw_rad = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Vec2 step = path[i] - path[i - 1];
    yaw_rad += errors.yaw_deg_per_sqrt_m * fleet::kDegree * std::sqrt(step.norm()) * rng.normal();
    const Vec3 seen =
        fleet::YawPose{yaw_rad, Vec3::Zero()}.turned(scale * Vec3(step.x(), step.y(), 0.0));
    out.odom_m.push_back(out.odom_m.back() + seen.head<2>());
  }
  return out;
}

fleet::RangeObservation observe(const Drive& a, const Drive& b, const fleet::YawPose& T_b_a,
                                std::size_t k, double t_s, double bias_m, double sigma_m,
                                Rng& rng) {
  fleet::RangeObservation o;
  o.t = Time::from_s(t_s);
  o.x_a_m.head<2>() = a.odom_m[k];
  o.y_b_m.head<2>() = b.odom_m[k];
  const Vec3 x(a.true_m[k].x(), a.true_m[k].y(), 0.0);
  const Vec3 y(b.true_m[k].x(), b.true_m[k].y(), 0.0);
  o.range_m = (T_b_a * x - y).norm() + bias_m + sigma_m * rng.normal();
  o.sigma_m = sigma_m;
  return o;
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

}  // namespace rali::frames_bench
