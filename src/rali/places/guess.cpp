#include "rali/places/guess.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace rali::places {

double yaw_of(const geometry::Mat3& R) { return std::atan2(R(1, 0), R(0, 0)); }

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

double yaw_sigma_rad(const Guess& guess) {
  return std::sqrt(std::max(0.0, guess.covariance(2, 2)));
}

double horizontal_sigma_m(const Guess& guess) {
  const Eigen::Matrix2d P = guess.covariance.block<2, 2>(3, 3);
  const double mean = 0.5 * P.trace();
  const double spread = std::hypot(0.5 * (P(0, 0) - P(1, 1)), P(0, 1));
  return std::sqrt(std::max(0.0, mean + spread));
}

namespace {

/// Minimum gate: a registration may differ this much from an overconfident guess.
constexpr double kMin_m = 0.3;
constexpr double kMin_rad = 0.03;

Eigen::Matrix2d gated(const Guess& guess, double gate) {
  Eigen::Matrix2d P = gate * gate * guess.covariance.block<2, 2>(3, 3);
  P.diagonal().array() += kMin_m * kMin_m;
  return P;
}

}  // namespace

geometry::Vec2 reach_m_of(const Guess& guess, double gate) {
  return gated(guess, gate).diagonal().cwiseMax(0.0).cwiseSqrt();
}

bool within(const Guess& guess, const geometry::SE3& T, double gate) {
  const double yaw = wrapped(yaw_of(T.R) - yaw_of(guess.T_target_source.R));
  if (std::abs(yaw) > gate * yaw_sigma_rad(guess) + kMin_rad) return false;
  const geometry::Vec2 d = (T.p - guess.T_target_source.p).head<2>();
  return d.dot(gated(guess, gate).inverse() * d) <= 1.0;
}

}  // namespace rali::places
