#include "rali/graph/marginals.hpp"

#include <limits>

namespace rali::graph {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::MatrixXd infinite(Eigen::Index n) {
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(n, n);
  P.diagonal().setConstant(kInfinity);
  return P;
}

Eigen::MatrixXd rows_of(const Eigen::MatrixXd& x, const std::vector<int>& rows) {
  Eigen::MatrixXd out(static_cast<Eigen::Index>(rows.size()), x.cols());
  for (Eigen::Index r = 0; r < out.rows(); ++r)
    out.row(r) = x.row(rows[static_cast<std::size_t>(r)]);
  return out;
}

}  // namespace

Marginals::Marginals(const Window& window, double huber_sd) : equations_(window, huber_sd) {
  solved_ = factorise_with_floor(equations_);
}

Eigen::MatrixXd Marginals::unit_columns(const std::vector<int>& columns) const {
  const auto n = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(equations_.gradient().size(), n);
  for (Eigen::Index c = 0; c < n; ++c) right(columns[static_cast<std::size_t>(c)], c) = 1.0;
  return right;
}

Eigen::MatrixXd Marginals::covariance(const std::vector<int>& columns) const {
  if (!solved_) return infinite(static_cast<Eigen::Index>(columns.size()));
  const Eigen::MatrixXd P = rows_of(equations_.solve(unit_columns(columns)), columns);
  return 0.5 * (P + P.transpose());
}

Eigen::MatrixXd Marginals::between(int a, const std::vector<int>& b) {
  if (!solved_) return Eigen::MatrixXd::Zero(own(a).rows(), static_cast<Eigen::Index>(b.size()));
  if (b != last_b_) {
    of_last_b_.emplace(equations_.cholesky(), unit_columns(b));
    last_b_ = b;
  }
  return of_last_b_->of(equations_.variable_at(a));
}

const Eigen::MatrixXd& Marginals::own(int column) {
  return diagonal()[static_cast<std::size_t>(equations_.variable_at(column))];
}

Eigen::MatrixXd Marginals::covariance(const LinearFactor& rows) const {
  return solved_ ? equations_.covariance(rows) : infinite(rows.r.size());
}

const std::vector<Eigen::MatrixXd>& Marginals::diagonal() {
  if (diagonal_) return *diagonal_;
  if (solved_) return diagonal_.emplace(equations_.cholesky().inverse_diagonal());
  diagonal_.emplace();
  for (const int dim : equations_.matrix().dims()) diagonal_->push_back(infinite(dim));
  return *diagonal_;
}

}  // namespace rali::graph
