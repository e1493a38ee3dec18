#pragma once

#include <Eigen/Core>

namespace rali::geometry {

/// Gain of the regression of a state on quantities with covariance `known`. `cross` is the
/// covariance of the state with them, one row per state component. Correlated quantities are not
/// counted twice.
[[nodiscard]] Eigen::MatrixXd regression(const Eigen::MatrixXd& cross,
                                         const Eigen::MatrixXd& known);

}  // namespace rali::geometry
