#pragma once

namespace rali::geometry {

/// Probability that chi-square with `dof` degrees of freedom is larger than x. 1 for x <= 0 and for
/// not-a-number.
[[nodiscard]] double chi2_tail(double x, int dof);

}  // namespace rali::geometry
