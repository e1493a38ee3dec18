#pragma once

#include <map>
#include <utility>
#include <vector>

#include <Eigen/SparseCholesky>

#include "rali/graph/linearise.hpp"

namespace rali::graph {

/// H d = -gradient of a window: blocks of 15 x 15 between keyframes, few of them off the diagonal,
/// bordered by the landmarks, biases and taus. In this order the Cholesky factor fills in within
/// the band and the border only.
class NormalEquations {
 public:
  /// Sums up all factors at the present values.
  NormalEquations(const Window& window, double huber_sd);

  /// Sums up again at other values of the same factors.
  void relinearise(const Window& window, double huber_sd);

  [[nodiscard]] double cost() const { return cost_; }

  [[nodiscard]] const Eigen::VectorXd& gradient() const { return gradient_; }

  /// Factors H + damping, where each diagonal element H_ii grows by `relative` H_ii + `absolute`.
  /// @return false if a pivot is not positive.
  [[nodiscard]] bool factorise(double relative, double absolute);

  /// Solves with the last factor.
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& right) const;

 private:
  using Sparse = Eigen::SparseMatrix<double>;

  void add(const LinearFactor& factor);
  void add_prior(const LinearPrior& prior);
  StateMat& block(int column, int row);
  template <class Put>
  void for_each_entry(const Put& put) const;
  void make_pattern();

  int keyframe_columns_ = 0;
  int border_ = 0;
  double cost_ = 0.0;
  Eigen::VectorXd gradient_;
  std::map<std::pair<int, int>, StateMat> blocks_;  ///< (column, row) >= diagonal, by keyframe
  Eigen::MatrixXd border_rows_;                     ///< globals x keyframe columns
  Eigen::MatrixXd corner_;                          ///< globals x globals, lower part
  bool has_pattern_ = false;
  Sparse matrix_;
  Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> ldlt_;
};

}  // namespace rali::graph
