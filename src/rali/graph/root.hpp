#pragma once

#include <Eigen/Core>

namespace rali::graph {

/// W with W^T W = information, for a matrix that may be singular and mixes units. Zeros (to
/// rounding, relative to the diagonal) stay exactly zero: W has no row for a degenerate direction.
[[nodiscard]] Eigen::MatrixXd information_root(const Eigen::MatrixXd& information);

/// W with W^T W = inverse of a covariance. A coordinate without variance gets a sigma of 1e-9 of
/// its unit, one that others determine 1e-5 of its own sigma.
[[nodiscard]] Eigen::MatrixXd covariance_root(const Eigen::MatrixXd& covariance);

/// Whether covariance_root() accepts it: finite, and positive but for rounding.
[[nodiscard]] bool is_covariance(const Eigen::MatrixXd& covariance);

}  // namespace rali::graph
