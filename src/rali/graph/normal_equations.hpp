#pragma once

#include "rali/graph/block_cholesky.hpp"
#include "rali/graph/linearise.hpp"

namespace rali::graph {

/// H d = -gradient of a window of any shape: a block per keyframe and global, eliminated by minimum
/// degree, landmarks, biases and taus last. The window must be laid out.
class NormalEquations {
 public:
  /// Sums all factors at the present values. The pattern and its order are computed here and kept:
  /// factors may change their values and weights, not their keyframes.
  NormalEquations(const Window& window, double huber_sd);

  /// The same, but these variables (ascending; see BlockLayout) are kept and the others eliminated:
  /// factorise() then computes cholesky().schur(), and solve() must not be called.
  NormalEquations(const Window& window, double huber_sd, const std::vector<int>& kept);

  /// Sums again at other values or weights of the same factors.
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

  /// J^T of a factor, as right side for H^-1 J^T.
  [[nodiscard]] Eigen::MatrixXd right_of(const LinearFactor& factor) const;

  /// J H^-1 J^T of a factor, once H is factored: the covariance of the quantity its rows measure.
  [[nodiscard]] Eigen::MatrixXd covariance(const LinearFactor& factor) const;

  [[nodiscard]] const BlockCholesky& cholesky() const { return cholesky_; }

  [[nodiscard]] const BlockMatrix& matrix() const { return H_; }

  /// Block index of a keyframe or global, by its first column.
  [[nodiscard]] int variable_at(int column) const {
    return variable_at_[static_cast<std::size_t>(column)];
  }

 private:
  void add_curvature(const LinearFactor& factor);
  void add_curvature(const LinearPrior& prior);

  std::vector<int> variable_at_;  ///< by first column of a keyframe or global
  BlockMatrix H_;
  BlockCholesky cholesky_;
  Slope slope_;
};

/// Factors without damping but with an information of 1e-12 of each diagonal element (1e-12 of its
/// unit if it is zero), so that unobservable directions get a huge variance instead of NaN. If a
/// pivot is still not positive, the floor is raised in steps.
/// @return false if no floor suffices
[[nodiscard]] bool factorise_with_floor(NormalEquations& equations);

/// Block index of each keyframe and global: free keyframes first, then globals.
struct BlockLayout {
  std::vector<int> dims;
  std::vector<int> variable_at;  ///< by first column; -1 at others
  std::vector<int> globals;      ///< which of them are globals

  explicit BlockLayout(const Window& window);
};

/// Blocks off the diagonal that the window's factors couple.
[[nodiscard]] std::vector<std::pair<int, int>> block_pairs(const Window& window,
                                                           const BlockLayout& layout);

}  // namespace rali::graph
