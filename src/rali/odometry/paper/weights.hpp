#pragma once

#include <vector>

#include "rali/geometry/types.hpp"
#include "rali/odometry/paper/settings.hpp"

namespace rali::odometry::paper {

/// Second and third quartile of the ranges of one scan's features [m].
struct RangeQuartiles {
  double q2_m = 0.0;
  double q3_m = 0.0;
};

/// By nearest rank, which is defined for samples; zeros without ranges. `ranges_m` is reordered.
[[nodiscard]] RangeQuartiles range_quartiles(std::vector<double>& ranges_m);

/// Far points get more weight: a logistic curve centred at the median. 1 if all ranges are 0.
/// Source: paper eq. (wr).
[[nodiscard]] double range_weight(double range_m, const RangeQuartiles& quartiles);

/// Ratio of neighbours to the wanted number, at most 1. Source: paper eq. (wn).
[[nodiscard]] double neighbour_weight(int neighbours, int wanted);

/// Angle between ray and normal, by setting times the range. `p` is the point in the sensor's frame
/// [m], `n` the plane's unit normal in the same frame.
/// Source: paper eq. (wk), upper case; readings kin_point, kin_abs, kin_scale (finding F6).
[[nodiscard]] double kinematic_weight(const geometry::Vec3& p, const geometry::Vec3& n,
                                      const RangeQuartiles& quartiles,
                                      const PaperSettings& settings);

/// Rotation angle [rad] of R by reading rot_angle (finding F7: as printed it is half the angle).
[[nodiscard]] double rotation_angle_rad(const geometry::Mat3& R, RotationAngle reading);

/// omega of one match. `turning`: the rotation of the scan exceeds theta_th_deg.
[[nodiscard]] double multi_metric_weight(const geometry::Vec3& p, const geometry::Vec3& n,
                                         int neighbours, bool turning,
                                         const RangeQuartiles& quartiles,
                                         const PaperSettings& settings);

/// Weight of r^2 in iterated least squares for rho(omega r) or omega rho(r), by setting.
[[nodiscard]] double irls_weight(double omega, double r_m, const PaperSettings& settings);

/// The loss itself: rho(omega r) or omega rho(r) with rho(x) = x^2/2 inside the knee.
[[nodiscard]] double robust_cost(double omega, double r_m, const PaperSettings& settings);

}  // namespace rali::odometry::paper
