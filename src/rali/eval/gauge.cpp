#include "rali/eval/gauge.hpp"

#include <cmath>

#include "rali/geometry/so3.hpp"

namespace rali::eval {

using geometry::SE3;

namespace {

/// Smaller differences are not motion: single scans at standstill differ by this much.
constexpr double kSame_m = 5e-3, kSame_rad = 5e-3;

bool same(const SE3& a, const SE3& b) {
  return (a.p - b.p).norm() < kSame_m &&
         geometry::so3_log(a.R.transpose() * b.R).norm() < kSame_rad;
}

}  // namespace

bool Gauge::holds(const PosePair& pair) const {
  return reference && same(pair.est, reference->est) && same(pair.ref, reference->ref);
}

Gauge gauge_of(const PosePair& reference) {
  return {reference.est * reference.ref.inverse(), reference};
}

Gauge gauge_of(const PosePair& reference, const PosePair& level) {
  const geometry::Mat3 R_level = level.est.R * level.ref.R.transpose();
  const geometry::Mat3 left = reference.est.R * (R_level * reference.ref.R).transpose();
  const double heading_rad = std::atan2(left(1, 0) - left(0, 1), left(0, 0) + left(1, 1));
  SE3 T;
  T.R = geometry::rotation_from_rpy(0.0, 0.0, heading_rad) * R_level;
  T.p = reference.est.p - T.R * reference.ref.p;
  return {T, reference};
}

}  // namespace rali::eval
