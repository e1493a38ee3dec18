#include "rali/odometry/travel_direction.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "rali/geometry/so3.hpp"

namespace rali::odometry {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
/// Long against the noise of a pose, short against a bend.
constexpr double kStep_m = 0.5;
constexpr int kSteps = 20;
constexpr double kDriven_m = 10.0;
/// A larger angle is no error of mounting: the body is defined otherwise.
constexpr double kMax_rad = 10.0 * kRadPerDeg;
/// Wheels are not aligned better.
constexpr double kWheels_rad = 0.05 * kRadPerDeg;
/// Prior of the lever for a path without turns: 1 m, at 0.02 m of noise.
constexpr double kNoise_m = 0.02, kLever_m = 1.0;

}  // namespace

void TravelDirection::add(const SE3& T_odom_body, const Vec3& forward_body, const Vec3& up_body) {
  if (!last_) last_ = T_odom_body;
  const SE3 step = last_->inverse() * T_odom_body;
  if (step.p.norm() < kStep_m) return;
  last_ = T_odom_body;
  const Vec3 left_body = up_body.cross(forward_body).normalized();
  // Seen from the heading half-way.
  const Vec3 turn = geometry::so3_log(step.R);
  const Vec3 moved_m = geometry::so3_exp(-0.5 * turn) * step.p;
  const double ahead_m = forward_body.dot(moved_m);
  const double left_m = left_body.dot(moved_m);
  const Eigen::Vector2d row(ahead_m, forward_body.cross(left_body).dot(turn));
  squares_ += row * row.transpose();
  products_ += left_m * row;
  sideways_m2_ += left_m * left_m;
  ahead_m_ += std::abs(ahead_m);
  ++steps_;
}

std::optional<TravelDirection::Angle> TravelDirection::angle() const {
  if (steps_ < kSteps || ahead_m_ < kDriven_m) return std::nullopt;
  Eigen::Matrix2d squares = squares_;
  squares(1, 1) += kNoise_m * kNoise_m / (kLever_m * kLever_m);
  const Eigen::Matrix2d inverse = squares.inverse();
  const Eigen::Vector2d fit = inverse * products_;
  if (!(std::abs(fit[0]) < kMax_rad)) return std::nullopt;
  const double left_m2 = std::max(0.0, sideways_m2_ - products_.dot(fit)) / (steps_ - 2);
  return Angle{fit[0], std::hypot(std::sqrt(left_m2 * inverse(0, 0)), kWheels_rad)};
}

}  // namespace rali::odometry
