#pragma once

#include <cstddef>
#include <vector>

namespace rali::eval {

/// Summary of errors; all zero for an empty list.
struct Statistics {
  std::size_t count = 0;
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;  ///< mean of the two middle values for an even count
  double std = 0.0;     ///< population (n)
  double min = 0.0;
  double max = 0.0;
  double sse = 0.0;
};

[[nodiscard]] Statistics statistics(std::vector<double> values);

/// The value below which the fraction q (0..1) of the values lies, linear between neighbours;
/// 0 for an empty list.
[[nodiscard]] double quantile(std::vector<double> values, double q);

/// Probability that chi-square with `dof` degrees of freedom is at most x.
[[nodiscard]] double chi2_cdf(double x, int dof);

/// The x with chi2_cdf(x, dof) = probability, for probability in (0, 1).
[[nodiscard]] double chi2_quantile(double probability, int dof);

}  // namespace rali::eval
