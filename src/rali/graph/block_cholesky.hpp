#pragma once

#include <vector>

#include "rali/graph/elimination.hpp"

namespace rali::graph {

/// Multifrontal Cholesky factor L L^T of a BlockMatrix: each front is dense, so the work is in
/// matrix products. The elimination order is computed once and reused by all factorisations.
class BlockCholesky {
 public:
  /// Parameters as for Elimination.
  BlockCholesky(const BlockMatrix& pattern, const std::vector<int>& last, bool keep_last = false);

  /// Factors the matrix; each diagonal element a grows by `relative` a + `absolute`. The matrix has
  /// the pattern given to the constructor.
  /// @return false if a pivot is not positive.
  [[nodiscard]] bool factorise(const BlockMatrix& matrix, double relative, double absolute);

  /// One or more right sides, each a column in the order of the matrix. Not with `keep_last`.
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

  /// A solution of which only a few blocks are needed: the others are not computed. The factor must
  /// not change meanwhile.
  class PartialSolution {
   public:
    PartialSolution(const BlockCholesky& factor, const Eigen::MatrixXd& right);

    /// The rows of one variable, as in the result of solve().
    [[nodiscard]] Eigen::MatrixXd of(int variable);

   private:
    const BlockCholesky& factor_;
    Eigen::MatrixXd x_;       ///< in elimination order; final in the fronts that are done
    std::vector<bool> done_;  ///< by front
  };

  /// With `keep_last`: Schur complement of the last variables, in their order.
  [[nodiscard]] const Eigen::MatrixXd& schur() const { return schur_; }

  /// Reduces a right side b in the same way: its tail is that of the Schur complement, its head
  /// L^-1 b.
  [[nodiscard]] Eigen::VectorXd reduce(const Eigen::VectorXd& right) const;

  /// Diagonal blocks of the inverse, by variable (Takahashi's recursion, on the fronts). Not with
  /// `keep_last`.
  [[nodiscard]] std::vector<Eigen::MatrixXd> inverse_diagonal() const;

  [[nodiscard]] const Elimination& elimination() const { return plan_; }

  /// Coefficients of the factor.
  [[nodiscard]] std::size_t stored() const;

 private:
  /// An entry of the matrix and its position in a front.
  struct Scatter {
    int entry = 0;
    int row = 0;
    int column = 0;
    bool transposed = false;
  };

  void assemble(const BlockMatrix& matrix, std::size_t s, double relative, double absolute,
                Eigen::MatrixXd& front);
  void forward(Eigen::MatrixXd& x) const;
  void backward(Eigen::MatrixXd& x) const;
  void backward_front(std::size_t s, Eigen::MatrixXd& x) const;
  [[nodiscard]] Eigen::MatrixXd permuted(const Eigen::MatrixXd& x, bool back) const;

  Elimination plan_;
  std::vector<int> first_at_;  ///< first unknown of each position in elimination order
  std::vector<std::vector<Scatter>> scatter_;
  std::vector<std::vector<int>> children_;
  bool keep_last_ = false;
  std::vector<Eigen::MatrixXd> panels_;   ///< of each front, its pivots' columns
  std::vector<Eigen::MatrixXd> updates_;  ///< of each front, for its parent; empty once used
  Eigen::MatrixXd schur_;
};

}  // namespace rali::graph
