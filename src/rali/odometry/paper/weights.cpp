#include "rali/odometry/paper/weights.hpp"

#include <algorithm>
#include <cmath>

#include "rali/geometry/robust.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::odometry::paper {

using geometry::Mat3;
using geometry::Vec3;

namespace {

constexpr double kRangeSteepness = 2.5;  // paper eq. (wr)

double nearest_rank(std::vector<double>& values, double quantile) {
  const auto rank =
      static_cast<std::ptrdiff_t>(std::ceil(quantile * static_cast<double>(values.size()))) - 1;
  const auto at = values.begin() + std::max<std::ptrdiff_t>(0, rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double huber_cost(double x, double knee) {
  const double a = std::abs(x);
  return a <= knee ? 0.5 * a * a : knee * (a - 0.5 * knee);
}

}  // namespace

RangeQuartiles range_quartiles(std::vector<double>& ranges_m) {
  if (ranges_m.empty()) return {};
  const double q3_m = nearest_rank(ranges_m, 0.75);
  return {nearest_rank(ranges_m, 0.5), q3_m};
}

double range_weight(double range_m, const RangeQuartiles& quartiles) {
  if (quartiles.q3_m <= 0.0) return 1.0;
  return 1.0 / (1.0 + std::exp(-kRangeSteepness / quartiles.q3_m * (range_m - quartiles.q2_m)));
}

double neighbour_weight(int neighbours, int wanted) {
  return neighbours >= wanted ? 1.0 : std::max(0, neighbours) / static_cast<double>(wanted);
}

double kinematic_weight(const Vec3& p, const Vec3& n, const RangeQuartiles& quartiles,
                        const PaperSettings& settings) {
  const double range_m = p.norm();
  double cosine = p.dot(n);
  if (settings.kin_point == KinematicPoint::kUnit) cosine = range_m > 0.0 ? cosine / range_m : 0.0;
  if (settings.kin_abs) cosine = std::abs(cosine);
  const double angle_rad = std::acos(std::clamp(cosine, -1.0, 1.0));
  switch (settings.kin_scale) {
    case KinematicScale::kMetre:
      return angle_rad * range_m;
    case KinematicScale::kQuartile:
      return quartiles.q3_m > 0.0 ? angle_rad * range_m / quartiles.q3_m : angle_rad;
    case KinematicScale::kNone:
      break;
  }
  return angle_rad;
}

double rotation_angle_rad(const Mat3& R, RotationAngle reading) {
  const double full = geometry::so3_log(R).norm();
  return reading == RotationAngle::kFull ? full : 0.5 * full;
}

double multi_metric_weight(const Vec3& p, const Vec3& n, int neighbours, bool turning,
                           const RangeQuartiles& quartiles, const PaperSettings& settings) {
  const double kinematic = turning ? kinematic_weight(p, n, quartiles, settings) : 0.0;
  return settings.eta[0] * range_weight(p.norm(), quartiles) +
         settings.eta[1] * neighbour_weight(neighbours, settings.n_neighbor) +
         settings.eta[2] * kinematic;
}

double irls_weight(double omega, double r_m, const PaperSettings& settings) {
  if (settings.weight_place == WeightPlace::kOutside) {
    return omega * geometry::huber_weight(r_m, settings.huber_m);
  }
  return omega * omega * geometry::huber_weight(omega * r_m, settings.huber_m);
}

double robust_cost(double omega, double r_m, const PaperSettings& settings) {
  if (settings.weight_place == WeightPlace::kOutside) {
    return omega * huber_cost(r_m, settings.huber_m);
  }
  return huber_cost(omega * r_m, settings.huber_m);
}

}  // namespace rali::odometry::paper
