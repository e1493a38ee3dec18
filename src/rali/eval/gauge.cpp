#include "rali/eval/gauge.hpp"

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

}  // namespace rali::eval
