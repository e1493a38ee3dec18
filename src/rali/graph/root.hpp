#pragma once

#include <Eigen/Core>

namespace rali::graph {

/// W with W^T W = information, for a matrix that may be singular and mixes units. What is zero (to
/// rounding, against the diagonal) stays exactly zero: W leaves a blind direction out.
[[nodiscard]] Eigen::MatrixXd information_root(const Eigen::MatrixXd& information);

/// W with W^T W = inverse of a covariance. A coordinate without any variance is taken as known to
/// 1e-9 of its unit, one that others determine to 1e-5 of its own sigma.
[[nodiscard]] Eigen::MatrixXd covariance_root(const Eigen::MatrixXd& covariance);

/// That covariance_root() can take it: finite, and positive but for rounding.
[[nodiscard]] bool is_covariance(const Eigen::MatrixXd& covariance);

}  // namespace rali::graph
