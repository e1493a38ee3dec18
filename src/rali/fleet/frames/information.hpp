#pragma once

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace rali::fleet {

/// (I^-1 + P)^-1 without inverting I: zero information stays zero. P may be singular.
template <class M>
[[nodiscard]] M with_error(const M& information, const M& covariance) {
  constexpr double kMin = 1e-10;  // keeps it regular: 0.01 mm, 0.01 mrad
  const M sum = information + (covariance + kMin * M::Identity()).inverse();
  const M out = information - information * sum.ldlt().solve(information);
  return 0.5 * (out + out.transpose());
}

}  // namespace rali::fleet
