#include "rali/graph/block_cholesky.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::graph {
namespace {

struct Sample {
  BlockMatrix blocks;
  Eigen::MatrixXd dense;
};

// A path of variables of mixed size with some chords, and two at the end that many touch.
Sample sample(int n, Rng& rng) {
  std::vector<int> dims;
  for (int v = 0; v < n; ++v) dims.push_back(v >= n - 2 ? 1 : (v % 5 == 0 ? 15 : 6));
  std::vector<std::pair<int, int>> pairs;
  for (int v = 0; v + 1 < n - 2; ++v) pairs.emplace_back(v, v + 1);
  for (int v = 0; v + 9 < n - 2; v += 4) pairs.emplace_back(v + 9, v);
  for (int v = 0; v < n - 2; v += 3) pairs.emplace_back(n - 1 - v % 2, v);
  Sample out{BlockMatrix(dims, pairs), {}};
  std::vector<int> first;
  int size = 0;
  for (const int dim : dims) {
    first.push_back(size);
    size += dim;
  }
  out.dense.setZero(size, size);
  for (const auto& e : out.blocks.entries()) {
    auto block = out.blocks.block(e.row, e.column);
    block = Eigen::MatrixXd::NullaryExpr(block.rows(), block.cols(), [&] { return rng.normal(); });
    if (e.row == e.column) {
      block = (block + block.transpose()).eval();
      block.diagonal().array() += 60.0;
    }
    const int r = first[static_cast<std::size_t>(e.row)];
    const int c = first[static_cast<std::size_t>(e.column)];
    out.dense.block(r, c, block.rows(), block.cols()) = block;
    out.dense.block(c, r, block.cols(), block.rows()) = block.transpose();
  }
  return out;
}

Eigen::MatrixXd right_sides(Eigen::Index rows, Eigen::Index cols, Rng& rng) {
  return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return rng.normal(); });
}

TEST(block_cholesky, solution_satisfies_the_dense_system) {
  Rng rng(1, "cholesky");
  for (const int n : {3, 4, 12, 60}) {
    const Sample s = sample(n, rng);
    BlockCholesky cholesky(s.blocks, {n - 2, n - 1});
    ASSERT_TRUE(cholesky.factorise(s.blocks, 0.0, 0.0));
    const Eigen::MatrixXd b = right_sides(s.dense.rows(), 3, rng);
    EXPECT_LT((s.dense * cholesky.solve(b) - b).norm(), 1e-10) << n;
  }
}

TEST(block_cholesky, damps_the_diagonal_and_nothing_else) {
  Rng rng(2, "damping");
  const Sample s = sample(20, rng);
  BlockCholesky cholesky(s.blocks, {});
  ASSERT_TRUE(cholesky.factorise(s.blocks, 0.5, 2.0));
  Eigen::MatrixXd damped = s.dense;
  damped.diagonal() = 1.5 * s.dense.diagonal().array() + 2.0;
  const Eigen::MatrixXd b = right_sides(s.dense.rows(), 1, rng);
  EXPECT_LT((damped * cholesky.solve(b) - b).norm(), 1e-10);
}

TEST(block_cholesky, partial_solution_equals_the_rows_of_the_full_solution) {
  Rng rng(6, "partial");
  const Sample s = sample(60, rng);
  BlockCholesky cholesky(s.blocks, {58, 59});
  ASSERT_TRUE(cholesky.factorise(s.blocks, 0.0, 0.0));
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(s.dense.rows(), 3);
  right.middleRows(7, 3) = right_sides(3, 3, rng);
  const Eigen::MatrixXd whole = cholesky.solve(right);
  EXPECT_LT((s.dense * whole - right).norm(), 1e-10);
  BlockCholesky::PartialSolution partial(cholesky, right);
  for (const int v : {59, 3, 3, 40, 0, 17}) {
    int first = 0;
    for (int k = 0; k < v; ++k) first += s.blocks.dim(k);
    EXPECT_EQ(partial.of(v), whole.middleRows(first, s.blocks.dim(v))) << v;
  }
}

TEST(block_cholesky, inverse_diagonal_equals_the_blocks_of_the_dense_inverse) {
  Rng rng(3, "inverse");
  const Sample s = sample(60, rng);
  BlockCholesky cholesky(s.blocks, {58, 59});
  ASSERT_TRUE(cholesky.factorise(s.blocks, 0.0, 0.0));
  const Eigen::MatrixXd inverse = s.dense.inverse();
  const std::vector<Eigen::MatrixXd> diagonal = cholesky.inverse_diagonal();
  int first = 0;
  for (int v = 0; v < 60; ++v) {
    const int dim = s.blocks.dim(v);
    EXPECT_LT(
        (diagonal[static_cast<std::size_t>(v)] - inverse.block(first, first, dim, dim)).norm(),
        1e-12)
        << v;
    first += dim;
  }
}

// Kept variables without a common block are coupled by the variables eliminated between them.
TEST(block_cholesky, gives_the_schur_complement_of_the_kept_variables) {
  Rng rng(4, "schur");
  const Sample s = sample(30, rng);
  const std::vector<int> kept{2, 17, 28, 29};
  BlockCholesky cholesky(s.blocks, kept, true);
  ASSERT_TRUE(cholesky.factorise(s.blocks, 0.0, 0.0));
  std::vector<int> keep;
  std::vector<int> drop;
  int column = 0;
  for (int v = 0; v < 30; ++v) {
    const bool is_kept = std::find(kept.begin(), kept.end(), v) != kept.end();
    for (int d = 0; d < s.blocks.dim(v); ++d) (is_kept ? keep : drop).push_back(column++);
  }
  const Eigen::MatrixXd H_aa = s.dense(drop, drop);
  const Eigen::MatrixXd H_ba = s.dense(keep, drop);
  const Eigen::MatrixXd schur = s.dense(keep, keep) - H_ba * H_aa.inverse() * H_ba.transpose();
  EXPECT_LT((cholesky.schur() - schur).norm(), 1e-9);
  const Eigen::VectorXd b = right_sides(s.dense.rows(), 1, rng);
  const Eigen::VectorXd reduced = cholesky.reduce(b);
  const Eigen::VectorXd b_a = b(drop);
  const Eigen::VectorXd expected = b(keep) - H_ba * (H_aa.inverse() * b_a);
  EXPECT_LT((reduced.tail(schur.rows()) - expected).norm(), 1e-9);
  EXPECT_NEAR(reduced.head(H_aa.rows()).squaredNorm(), b_a.dot(H_aa.inverse() * b_a), 1e-9);
}

TEST(block_cholesky, refuses_indefinite_or_nan_matrices) {
  Rng rng(5, "refuses");
  Sample s = sample(12, rng);
  BlockCholesky cholesky(s.blocks, {});
  s.blocks.block(3, 3)(2, 2) = -1.0;
  EXPECT_FALSE(cholesky.factorise(s.blocks, 0.0, 0.0));
  s.blocks.block(3, 3)(2, 2) = std::nan("");
  EXPECT_FALSE(cholesky.factorise(s.blocks, 0.0, 0.0));
}

// A ladder of 4 x 200: without a fill-reducing order its factor would be dense.
TEST(block_cholesky, has_little_fill_in_on_a_ladder_of_four_vehicles) {
  std::vector<std::pair<int, int>> pairs;
  constexpr int kVehicles = 4;
  constexpr int kNodes = 200;
  for (int v = 0; v < kVehicles; ++v) {
    for (int k = 0; k < kNodes; ++k) {
      const int at = v * kNodes + k;
      if (k + 1 < kNodes) pairs.emplace_back(at, at + 1);
      if (v + 1 < kVehicles) pairs.emplace_back(at, at + kNodes);
    }
  }
  const BlockMatrix blocks(std::vector<int>(kVehicles * kNodes, 6), pairs);
  const BlockCholesky cholesky(blocks, {});
  const std::size_t dense = 36 * 800 * 801 / 2;
  EXPECT_LT(cholesky.stored(), dense / 20);
}

}  // namespace
}  // namespace rali::graph
