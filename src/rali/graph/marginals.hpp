#pragma once

#include <optional>
#include <vector>

#include "rali/graph/normal_equations.hpp"

namespace rali::graph {

/// Covariances of a window of any shape, from one factorisation without damping but with a floor
/// for unobservable directions (factorise_with_floor()). If that fails, all variances are infinite.
class Marginals {
 public:
  Marginals(const Window& window, double huber_sd);
  Marginals(const Marginals&) = delete;  // the solution refers to the factor
  Marginals& operator=(const Marginals&) = delete;

  /// Rows and columns of the covariance for these columns of the window, in their order.
  [[nodiscard]] Eigen::MatrixXd covariance(const std::vector<int>& columns) const;

  /// J P J^T of a factor's rows.
  [[nodiscard]] Eigen::MatrixXd covariance(const LinearFactor& rows) const;

  /// Covariance of the keyframe or global whose first column is `a` (rows) with the unknowns `b`
  /// (columns). The solution for `b` is cached: request all pairs with the same `b` in a row.
  [[nodiscard]] Eigen::MatrixXd between(int a, const std::vector<int>& b);

  /// Diagonal block of the keyframe or global whose first column this is; the first call computes
  /// all of them.
  [[nodiscard]] const Eigen::MatrixXd& own(int column);

 private:
  /// Diagonal block of each free keyframe and then of each global, all at once.
  [[nodiscard]] const std::vector<Eigen::MatrixXd>& diagonal();
  [[nodiscard]] Eigen::MatrixXd unit_columns(const std::vector<int>& columns) const;

  NormalEquations equations_;
  bool solved_ = false;
  std::vector<int> last_b_;
  std::optional<BlockCholesky::PartialSolution> of_last_b_;
  std::optional<std::vector<Eigen::MatrixXd>> diagonal_;
};

}  // namespace rali::graph
