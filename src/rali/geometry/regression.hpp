#pragma once

#include <Eigen/Core>

namespace rali::geometry {

/// Gain of the regression of a state on quantities with covariance `known`, whose covariance with
/// the state is `cross` (one row for each of the state's numbers). Quantities that hang on each
/// other count once.
[[nodiscard]] Eigen::MatrixXd regression(const Eigen::MatrixXd& cross,
                                         const Eigen::MatrixXd& known);

}  // namespace rali::geometry
