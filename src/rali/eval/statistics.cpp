#include "rali/eval/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace rali::eval {

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const double position = std::clamp(q, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(position);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  const double part = position - static_cast<double>(low);
  return values[low] + part * (values[high] - values[low]);
}

Statistics statistics(std::vector<double> values) {
  Statistics s;
  s.count = values.size();
  if (values.empty()) return s;
  const double n = static_cast<double>(s.count);
  for (const double v : values) {
    s.sse += v * v;
    s.mean += v / n;
  }
  double spread = 0.0;
  for (const double v : values) spread += (v - s.mean) * (v - s.mean) / n;
  s.rmse = std::sqrt(s.sse / n);
  s.std = std::sqrt(spread);
  s.min = *std::min_element(values.begin(), values.end());
  s.max = *std::max_element(values.begin(), values.end());
  s.median = quantile(std::move(values), 0.5);
  return s;
}

double chi2_cdf(double x, int dof) {
  if (!(x > 0.0)) return 0.0;
  // Regularised lower incomplete gamma function P(a, y), series for small y and Lentz's continued
  // fraction for large y (Abramowitz and Stegun 6.5.29, 6.5.31).
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
    return scale * sum;
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
  return 1.0 - scale * fraction;
}

double chi2_quantile(double probability, int dof) {
  double low = 0.0;
  double high = static_cast<double>(dof) + 10.0;
  while (chi2_cdf(high, dof) < probability && high < 1e9) high *= 2.0;
  for (int i = 0; i < 200 && high - low > 1e-12 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (chi2_cdf(middle, dof) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace rali::eval
