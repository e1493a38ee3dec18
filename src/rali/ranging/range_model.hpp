#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "rali/geometry/se3.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// One end of a range: a vehicle at the instant of the range, and where its antenna sits. Both ends
/// of a range in the same odom frame.
struct RangeEnd {
  geometry::SE3 T_odom_body;
  geometry::Vec3 p_body_antenna_m = geometry::Vec3::Zero();  ///< lever arm, in the body
  geometry::Vec3 v_odom_mps = geometry::Vec3::Zero();
  geometry::Vec3 w_body_radps = geometry::Vec3::Zero();

  [[nodiscard]] geometry::Vec3 antenna_odom_m() const { return T_odom_body * p_body_antenna_m; }

  /// Velocity of the antenna: that of the body and that of its rotation at the lever arm.
  [[nodiscard]] geometry::Vec3 antenna_v_odom_mps() const {
    return v_odom_mps + T_odom_body.R * w_body_radps.cross(p_body_antenna_m);
  }
};

/// Predicted range between two ends, and its derivatives by the right perturbation
/// R <- R Exp(theta), p <- p + d (d in odom), as in geometry::boxplus. The derivative by a bias
/// added to rho is 1, by a time offset added to the stamp rate_mps.
struct RangePrediction {
  using Row3 = Eigen::RowVector3d;

  double rho_m = 0.0;
  geometry::Vec3 e = geometry::Vec3::Zero();  ///< unit vector in odom, from k to j
  Row3 d_theta_j = Row3::Zero();
  Row3 d_p_j = Row3::Zero();
  Row3 d_theta_k = Row3::Zero();
  Row3 d_p_k = Row3::Zero();
  double rate_mps = 0.0;  ///< d rho / dt
};

/// rho = |R_j l_j + p_j - R_k l_k - p_k| and its derivatives (algorithms 4.1). Nothing if the
/// antennas are nearer than `near_m` (there is no direction, and radios are in the near field) or
/// if a number is not finite.
[[nodiscard]] std::optional<RangePrediction> predict(const RangeEnd& j, const RangeEnd& k,
                                                     double near_m);

/// The same to a fixed antenna position in odom: a landmark, or a vehicle at standstill whose own
/// pose is not estimated. d_p_k is the derivative by that position, d_theta_k is zero.
[[nodiscard]] std::optional<RangePrediction> predict(const RangeEnd& j,
                                                     const geometry::Vec3& p_odom_antenna_k_m,
                                                     double near_m);

/// Sigma of one range in line of sight: that of the sample, if it has one, but not below
/// `sigma_min_m`, else sqrt(sigma^2 + (sigma_per_m rho)^2) (algorithms 4.1).
[[nodiscard]] double sigma_of(double range_m, const RangeLimits& limits, double sample_sigma_m);

}  // namespace rali::ranging
