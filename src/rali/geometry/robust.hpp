#pragma once

#include <cmath>

namespace rali::geometry {

/// IRLS weight of the Huber loss: 1 inside `knee`, knee/|r| outside.
[[nodiscard]] inline double huber_weight(double r, double knee) {
  const double a = std::abs(r);
  return a <= knee ? 1.0 : knee / a;
}

/// IRLS weight of the Cauchy loss with scale c.
[[nodiscard]] inline double cauchy_weight(double r, double c) {
  const double u = r / c;
  return 1.0 / (1.0 + u * u);
}

}  // namespace rali::geometry
