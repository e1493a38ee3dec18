#pragma once

#include <optional>
#include <vector>

#include "rali/graph/global_equations.hpp"
#include "rali/graph/marginals.hpp"

namespace rali::graph {

/// Covariances of a window of any shape, with the floor of Marginals under what nothing holds.
class GlobalMarginals {
 public:
  GlobalMarginals(const Window& window, double huber_sd);

  /// Rows and columns of the covariance for these columns of the window, in their order.
  [[nodiscard]] Eigen::MatrixXd covariance(const std::vector<int>& columns) const;

  /// J P J^T of a factor's rows.
  [[nodiscard]] Eigen::MatrixXd covariance(const LinearFactor& rows) const;

  /// Own block of each free keyframe and then of each global, all at once.
  [[nodiscard]] const std::vector<Eigen::MatrixXd>& diagonal();

 private:
  GlobalEquations equations_;
  bool solved_ = false;
  std::optional<std::vector<Eigen::MatrixXd>> diagonal_;
};

}  // namespace rali::graph
