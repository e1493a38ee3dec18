#include "rali/graph/root.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "rali/base/assert.hpp"

namespace rali::graph {

namespace {

// Smaller eigenvalues of a matrix scaled to unit diagonal are rounding of zero.
constexpr double kZeroEigenvalue = 1e-12;
constexpr double kSigmaMin = 1e-9;
constexpr double kCorrelationSlack = 1e-10;

Eigen::VectorXd unscale_of(const Eigen::MatrixXd& covariance) {
  return covariance.diagonal().cwiseMax(kSigmaMin * kSigmaMin).cwiseSqrt().cwiseInverse();
}

Eigen::MatrixXd correlations(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& unscale) {
  Eigen::MatrixXd unit =
      unscale.asDiagonal() * (0.5 * (covariance + covariance.transpose())) * unscale.asDiagonal();
  unit.diagonal().setConstant(1.0 + kCorrelationSlack);
  return unit;
}

}  // namespace

Eigen::MatrixXd information_root(const Eigen::MatrixXd& information) {
  RALI_ASSERT(information.allFinite());
  const Eigen::VectorXd scale = information.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd unscale = scale.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  const Eigen::MatrixXd unit =
      unscale.asDiagonal() * (0.5 * (information + information.transpose())) * unscale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(unit);
  const double minimum = kZeroEigenvalue * eigen.eigenvalues().maxCoeff();
  const Eigen::VectorXd roots = eigen.eigenvalues().unaryExpr(
      [minimum](double value) { return value > minimum ? std::sqrt(value) : 0.0; });
  return roots.asDiagonal() * eigen.eigenvectors().transpose() * scale.asDiagonal();
}

bool is_covariance(const Eigen::MatrixXd& covariance) {
  if (!covariance.allFinite()) return false;
  return Eigen::LLT<Eigen::MatrixXd>(correlations(covariance, unscale_of(covariance))).info() ==
         Eigen::Success;
}

Eigen::MatrixXd covariance_root(const Eigen::MatrixXd& covariance) {
  RALI_ASSERT(covariance.allFinite());
  const Eigen::VectorXd unscale = unscale_of(covariance);
  const Eigen::MatrixXd unit = correlations(covariance, unscale);
  const Eigen::LLT<Eigen::MatrixXd> llt(unit);
  RALI_ASSERT(llt.info() == Eigen::Success);
  const Eigen::MatrixXd inverse_root =
      llt.matrixL().solve(Eigen::MatrixXd::Identity(unit.rows(), unit.cols()));
  return inverse_root * unscale.asDiagonal();
}

}  // namespace rali::graph
