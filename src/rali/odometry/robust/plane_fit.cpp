#include "rali/odometry/robust/plane_fit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace rali::odometry {

using geometry::Mat3;
using geometry::Vec3;
using geometry::Vec3f;

Mat3 PointSums::covariance() const {
  const double inverse = 1.0 / n;
  const Vec3 m = sum * inverse;
  Mat3 C;
  C(0, 0) = products[0] * inverse - m.x() * m.x();
  C(1, 0) = products[1] * inverse - m.x() * m.y();
  C(2, 0) = products[2] * inverse - m.x() * m.z();
  C(1, 1) = products[3] * inverse - m.y() * m.y();
  C(2, 1) = products[4] * inverse - m.y() * m.z();
  C(2, 2) = products[5] * inverse - m.z() * m.z();
  C(0, 1) = C(1, 0);
  C(0, 2) = C(2, 0);
  C(1, 2) = C(2, 1);
  return C;
}

Mat3 PointSums::mean_ray_product() const {
  const double inverse = 1.0 / n;
  Mat3 U;
  U << rays[0], rays[1], rays[2], rays[1], rays[3], rays[4], rays[2], rays[4], rays[5];
  return inverse * U;
}

Mat3 PointSums::noise_in(const Mat3& C, double range_var) const {
  using Rows = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
  constexpr double kMin_m2 = 1e-8;  // C of points on a line has no inverse
  const double inverse = 1.0 / n;
  const Mat3 U = mean_ray_product();
  const Vec3 w = inverse * Eigen::Map<const Vec3f>(leaving).cast<double>();
  const Mat3 W = inverse * Eigen::Map<const Rows>(leaving_at).cast<double>();
  const Mat3 A = range_var * (U - W + w * (inverse * sum).transpose());
  const Mat3 inverse_C = (C + kMin_m2 * Mat3::Identity()).inverse();
  const double explained = std::min(range_var, (A * inverse_C * A.transpose()).trace());
  return A + A.transpose() - explained * U;
}

namespace {

/// Unevenness of a surface [m]. 3, 5, 7 and 8 mm gave equal results in simulation: the cones of
/// rings are grazed at thousandths to hundredths of a radian, where each value leaves no width.
constexpr double kUneven_m = 0.005;

/// The part of the spread along `across` that comes from the surface, not from grazing rays [m^2].
///
/// If a ray meets a surface at the angle g, an unevenness h moves the point along the ray by h /
/// sin g; an angular error of the pose has the same effect. The points of one ring lie on its cone
/// whatever the surface, so their best plane is that of the cone: wide along the rays, thin, and
/// tilted by the angle of the ring. A surface is never seen edge-on. A plane that contains its rays
/// would be grazed at an angle at which nothing of its spread remains.
/// @param rays  mean of ray ray^T
double width_beyond_grazing(double spread_m2, const Vec3& across, const Vec3& normal,
                            const Mat3& rays) {
  constexpr double kMin = 1e-8;
  const double sine2 = std::max(kMin, normal.dot(rays * normal));
  return spread_m2 - kUneven_m * kUneven_m / sine2 * across.dot(rays * across);
}

/// Extent of a plane's points from their mean: sqrt(3) sigma if they are uniform, plus a margin for
/// a patch that grows while the vehicle drives. Beyond it a plane of a whole cell extrapolates. Two
/// rings on two surfaces, such as wall and ceiling, span a plane that is 10 degrees off: half a
/// metre from both the error is a decimetre.
double reach(double spread_m2) {
  constexpr double kSigmas = 2.0;  // 3: half of the gain
  constexpr double kMargin_m = 0.05;
  return kSigmas * std::sqrt(spread_m2) + kMargin_m;
}

/// In one cell of six, ten points of a round blob look four times as wide as thick, and a blob's
/// normal points anywhere, also along a tunnel. Tests whether two equal spreads differ as much by
/// chance: with W = 4 a b/(a + b)^2, W^((n - 2)/2) is uniform (Mauchly 1940, two dimensions).
bool flat_by_chance(double wide, double thick, double n) {
  constexpr double kChance = 0.03;
  const double sum = wide + thick;
  if (!(sum > 0.0)) return true;
  return std::pow(4.0 * wide * thick / (sum * sum), 0.5 * (n - 2.0)) > kChance;
}

}  // namespace

FitResult fit_plane(const PointSums& sums, const Vec3& origin, double edge_m, bool finest,
                    const PlaneSettings& settings, Plane& plane) {
  if (sums.n < settings.points_min) return FitResult::kTooFew;
  // Range noise lies along the rays. One ring on the floor spreads along them like a narrow plane,
  // and its best plane contains the ray instead of the floor: a false plane tilted by the ray's
  // angle. So the noise is subtracted before the axes are computed.
  const Mat3 measured = sums.covariance();
  const double range_var = settings.range_sigma_m * settings.range_sigma_m;
  const geometry::Pca3 pca = geometry::pca3(measured - sums.noise_in(measured, range_var));
  const Vec3 normal = pca.vectors.col(2);
  // Spread that the full noise could explain makes a surface neither thick nor wide.
  const Mat3 rays = sums.mean_ray_product();
  const Mat3 minimum = measured - range_var * rays;
  const double thickness_m2 = normal.dot(minimum * normal);
  const Vec3 across = pca.vectors.col(1);
  const double spread_m2 = std::min(pca.values[1], across.dot(minimum * across));
  const double width_m2 = width_beyond_grazing(spread_m2, across, normal, rays);
  const double excess = finest ? settings.excess_max_finest_m : settings.excess_max_m;
  if (thickness_m2 > excess * excess) return FitResult::kTooThick;
  const double width = settings.width_min_ratio * edge_m;
  if (width_m2 < width * width) return FitResult::kTooFew;
  const double l3 = std::max(0.0, normal.dot(measured * normal));
  if (width_m2 < 4.0 * l3) return finest ? FitResult::kTooFew : FitResult::kTooThick;
  // Three spots always lie in a plane.
  const double m = sums.samples;
  if (m < 4.0 || flat_by_chance(width_m2, l3, m)) return FitResult::kTooFew;
  const double n = sums.n;
  const double floor = settings.sigma_floor_m * settings.sigma_floor_m;
  const double s2 = std::max(floor, l3 * m / (m - 3.0));
  // Scans disagree by millimetres, which over a narrow plane is a large tilt.
  const double between = settings.sigma_between_m * settings.sigma_between_m;
  plane.q = origin + sums.sum / n;
  plane.e1 = pca.vectors.col(0);
  plane.e2 = pca.vectors.col(1);
  plane.n = normal;
  // A slope is the mean product of position and height, divided by the true spread. Measured
  // positions spread more than that, and the density at the faces is estimated from few points.
  const auto var_tilt = [&](const Vec3& e, double spread) {
    const double cross = range_var * e.dot(rays * normal);
    const double product =
        (e.dot(measured * e) * s2 + cross * cross / (2.0 * PointSums::kShell)) / n;
    return (product / spread + between) / spread;
  };
  plane.var_tilt1 = var_tilt(plane.e1, pca.values[0]);
  plane.var_tilt2 = var_tilt(plane.e2, pca.values[1]);
  plane.var_offset = s2 / n + settings.sigma_systematic_m * settings.sigma_systematic_m;
  plane.var_normal = s2;
  plane.reach1_m = reach(pca.values[0]);
  plane.reach2_m = reach(pca.values[1]);
  plane.epoch = sums.epoch_sum / n;
  return FitResult::kPlane;
}

}  // namespace rali::odometry
