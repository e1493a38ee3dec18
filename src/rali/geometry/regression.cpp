#include "rali/geometry/regression.hpp"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace rali::geometry {

Eigen::MatrixXd regression(const Eigen::MatrixXd& cross, const Eigen::MatrixXd& known) {
  // Metres, seconds and speeds are mixed: scaling by their sigmas makes one eigenvalue limit valid.
  constexpr double kNone = 1e-10;
  const Eigen::VectorXd scale =
      known.diagonal().unaryExpr([](double v) { return v > 0.0 ? 1.0 / std::sqrt(v) : 0.0; });
  const Eigen::MatrixXd scaled = scale.asDiagonal() * known * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  const Eigen::VectorXd inverse =
      solver.eigenvalues().unaryExpr([](double v) { return v > kNone ? 1.0 / v : 0.0; });
  const Eigen::MatrixXd V = solver.eigenvectors();
  return cross * scale.asDiagonal() * V * inverse.asDiagonal() * V.transpose() * scale.asDiagonal();
}

}  // namespace rali::geometry
