#include "rali/odometry/side_filter.hpp"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace rali::odometry {

Eigen::MatrixXd regression(const Eigen::MatrixXd& cross, const SideStates::Matrix& known) {
  // Metres, seconds and speeds side by side: in units of their sigmas, so that small is small.
  constexpr double kNone = 1e-10;
  const SideStates::Vector scale =
      known.diagonal().unaryExpr([](double v) { return v > 0.0 ? 1.0 / std::sqrt(v) : 0.0; });
  const SideStates::Matrix scaled = scale.asDiagonal() * known * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<SideStates::Matrix> solver(scaled);
  const SideStates::Vector inverse =
      solver.eigenvalues().unaryExpr([](double v) { return v > kNone ? 1.0 / v : 0.0; });
  const SideStates::Matrix V = solver.eigenvectors();
  return cross * scale.asDiagonal() * V * inverse.asDiagonal() * V.transpose() * scale.asDiagonal();
}

}  // namespace rali::odometry
