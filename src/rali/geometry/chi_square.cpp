#include "rali/geometry/chi_square.hpp"

#include <cmath>

namespace rali::geometry {

double chi2_tail(double x, int dof) {
  if (!(x > 0.0)) return 1.0;
  // Regularised incomplete gamma functions: series for small y, Lentz's continued fraction for
  // large y (Abramowitz and Stegun 6.5.29, 6.5.31).
  const double a = 0.5 * dof;
  const double y = 0.5 * x;
  const double scale = std::exp(-y + a * std::log(y) - std::lgamma(a));
  constexpr int kTerms = 2000;
  if (y < a + 1.0) {
    double term = 1.0 / a;
    double sum = term;
    for (int k = 1; k < kTerms && term > 1e-16 * sum; ++k) {
      term *= y / (a + k);
      sum += term;
    }
    return 1.0 - scale * sum;
  }
  double b = y + 1.0 - a;
  double c = 1e300;
  double d = 1.0 / b;
  double fraction = d;
  for (int k = 1; k < kTerms; ++k) {
    const double numerator = -k * (k - a);
    b += 2.0;
    d = 1.0 / (numerator * d + b);
    c = b + numerator / c;
    fraction *= c * d;
    if (std::abs(c * d - 1.0) < 1e-15) break;
  }
  return scale * fraction;
}

}  // namespace rali::geometry
