#include "rali/eval/statistics.hpp"

#include <algorithm>
#include <cmath>

#include "rali/geometry/chi_square.hpp"

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

double chi2_cdf(double x, int dof) { return 1.0 - geometry::chi2_tail(x, dof); }

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
