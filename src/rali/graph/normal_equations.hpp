#pragma once

#include "rali/graph/block_cholesky.hpp"
#include "rali/graph/linearise.hpp"

namespace rali::graph {

/// H d = -gradient of a window of any shape: a block per keyframe and global, eliminated by minimum
/// degree, landmarks, biases and taus last. The window must be laid out.
class NormalEquations {
 public:
  /// Sums up all factors at the present values. The pattern and its order are found here and kept:
  /// factors may change their values and weights, not their keyframes.
  NormalEquations(const Window& window, double huber_sd);

  /// The same, where these variables (growing; see BlockLayout) are kept and the others eliminated:
  /// then cholesky().schur() is what factorise() makes, and solve() is not to be called.
  NormalEquations(const Window& window, double huber_sd, const std::vector<int>& kept);

  /// Sums up again at other values or weights of the same factors.
  void relinearise(const Window& window, double huber_sd);

  struct Slope {
    Eigen::VectorXd gradient;
    double cost = 0.0;
  };

  /// Gradient and cost at other values, without H.
  [[nodiscard]] static Slope slope(const Window& window, double huber_sd);

  [[nodiscard]] double cost() const { return slope_.cost; }

  [[nodiscard]] const Eigen::VectorXd& gradient() const { return slope_.gradient; }

  /// Factors H + damping, where each diagonal element H_ii grows by `relative` H_ii + `absolute`.
  /// @return false if a pivot is not positive.
  [[nodiscard]] bool factorise(double relative, double absolute) {
    return cholesky_.factorise(H_, relative, absolute);
  }

  /// Solves with the last factor, one or more right sides.
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const {
    return cholesky_.solve(right);
  }

  /// J^T of a factor: what solve() makes H^-1 J^T of.
  [[nodiscard]] Eigen::MatrixXd right_of(const LinearFactor& factor) const;

  /// J H^-1 J^T of a factor, once H is factored: the covariance of what its rows measure.
  [[nodiscard]] Eigen::MatrixXd covariance(const LinearFactor& factor) const;

  [[nodiscard]] const BlockCholesky& cholesky() const { return cholesky_; }

  [[nodiscard]] const BlockMatrix& matrix() const { return H_; }

  /// Which block a keyframe or global is, by its first column.
  [[nodiscard]] int variable_at(int column) const {
    return variable_at_[static_cast<std::size_t>(column)];
  }

 private:
  void add_curvature(const LinearFactor& factor);
  void add_curvature(const LinearPrior& prior);

  std::vector<int> variable_at_;  ///< of each column that is the first of a keyframe or global
  BlockMatrix H_;
  BlockCholesky cholesky_;
  Slope slope_;
};

/// Factors without damping but with an information of 1e-12 of each diagonal element (1e-12 of its
/// unit where there is none), so that what nothing holds gets a variance that is huge and not NaN.
/// Where even that is not enough for a positive pivot it is raised in steps.
/// @return false if none helps
[[nodiscard]] bool factorise_with_floor(NormalEquations& equations);

/// What block of the pattern each keyframe and global is: free keyframes first, then globals.
struct BlockLayout {
  std::vector<int> dims;
  std::vector<int> variable_at;  ///< of each first column; -1 at others
  std::vector<int> globals;      ///< which of them are globals

  explicit BlockLayout(const Window& window);
};

/// Blocks off the diagonal that the factors of the window touch.
[[nodiscard]] std::vector<std::pair<int, int>> block_pairs(const Window& window,
                                                           const BlockLayout& layout);

}  // namespace rali::graph
