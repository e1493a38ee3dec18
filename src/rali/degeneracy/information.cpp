#include "rali/degeneracy/information.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace rali::degeneracy {

using geometry::Mat3;
using geometry::Mat6;
using geometry::Vec3;
using geometry::Vec6;

namespace {

constexpr double kRelativeCut = 1e-6;  // eigenvalues below this fraction are rounding errors
constexpr double kDegree = std::numbers::pi / 180.0;

Mat3 pseudo_inverse(const Mat3& S) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(S);
  const double cut = kRelativeCut * std::max(0.0, solver.eigenvalues()[2]);
  Mat3 out = Mat3::Zero();
  for (int k = 0; k < 3; ++k) {
    const double l = solver.eigenvalues()[k];
    if (l > cut && l > 0.0) {
      out += solver.eigenvectors().col(k) * solver.eigenvectors().col(k).transpose() / l;
    }
  }
  return out;
}

/// Information of one 3x3 block with the other one marginalised (Schur complement).
Mat3 decoupled(const Mat6& I, int block, int other) {
  const Mat3 cross = I.block<3, 3>(block, other);
  return I.block<3, 3>(block, block) -
         cross * pseudo_inverse(I.block<3, 3>(other, other)) * cross.transpose();
}

Category category_of(double sigma, double full, double none) {
  if (sigma < full) return Category::kFull;
  return sigma > none ? Category::kNone : Category::kPartial;
}

/// Information that uncertain normals give by chance: a sum of squares, one per plane.
class Chance {
 public:
  double mean = 0.0;

  void add(double expected) {
    mean += expected;
    squares_ += expected * expected;
  }

  /// Bound on the information by chance. One plane gives at most kappa times its expectation, which
  /// is (kappa - 1)/sqrt(2) sigma above it. For independent planes, the same number of sigmas above
  /// the mean of their sum is a smaller factor. In a young map with inertial data, a wrong speed
  /// makes all planes wrong in common, so the factor is needed.
  [[nodiscard]] double at_most(double kappa, bool independent) const {
    return independent ? mean + (kappa - 1.0) * std::sqrt(squares_) : kappa * mean;
  }

 private:
  double squares_ = 0.0;
};

/// Information along v in a decoupled block, with the expected noise contribution removed.
DirectionInfo direction(const Vec3& direction_odom, const Vec3& v, const Mat3& decoupled_block,
                        const Mat3& full_block, double noise, double noise_max) {
  DirectionInfo info;
  info.direction_odom = direction_odom;
  info.raw = std::max(0.0, v.dot(decoupled_block * v));
  const double coupled = v.dot(full_block * v);
  const double fraction = coupled > 0.0 ? info.raw / coupled : 0.0;
  info.noise = noise * fraction;
  info.information = std::max(0.0, info.raw - noise_max * fraction);
  info.sigma = info.information > 0.0 ? 1.0 / std::sqrt(info.information)
                                      : std::numeric_limits<double>::infinity();
  return info;
}

}  // namespace

Axes physical_axes(const Mat6& I, const Vec3& g_odom_mps2, const Axes& previous,
                   const AwareSettings& settings) {
  const Vec3 up = -g_odom_mps2.normalized();
  const Vec3 helper = std::abs(up.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 h1 = (helper - helper.dot(up) * up).normalized();
  const Vec3 h2 = up.cross(h1);
  const Mat3 I_t = decoupled(I, 3, 0);
  const double a = h1.dot(I_t * h1);
  const double b = h1.dot(I_t * h2);
  const double c = h2.dot(I_t * h2);
  const double mean = 0.5 * (a + c);
  const double spread = std::hypot(0.5 * (a - c), b);
  Axes axes;
  if (mean + spread <= settings.axis_ratio_min * (mean - spread)) {
    // No direction stands out: keep the last axes, projected on the current horizontal plane.
    Vec3 axial = previous.col(0) - previous.col(0).dot(up) * up;
    if (axial.norm() < 1e-3) axial = h1;
    axes.col(0) = axial.normalized();
  } else {
    const double angle = 0.5 * std::atan2(-b, -0.5 * (a - c));  // of the smaller eigenvector
    axes.col(0) = std::cos(angle) * h1 + std::sin(angle) * h2;
    if (axes.col(0).dot(previous.col(0)) < 0.0) axes.col(0) *= -1.0;
  }
  axes.col(2) = up;
  axes.col(1) = up.cross(Vec3(axes.col(0)));
  return axes;
}

std::array<DirectionInfo, 6> direction_information(const Mat6& I,
                                                   std::span<const PlaneEvidence> planes,
                                                   const Mat3& R_odom_body, const Axes& axes,
                                                   const AwareSettings& settings) {
  // Normals are uncertain: by chance alone, a plane adds w v^T S v along v.
  std::array<Chance, 3> chance_t, chance_r;
  for (const PlaneEvidence& plane : planes) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 d = axes.col(static_cast<int>(k));
      const Vec3 arm = d.cross(plane.lever_odom_m);
      chance_t[k].add(plane.weight * d.dot(plane.normal_covariance * d));
      chance_r[k].add(plane.weight * arm.dot(plane.normal_covariance * arm));
    }
  }
  const Mat3 I_t = decoupled(I, 3, 0);
  const Mat3 I_r = decoupled(I, 0, 3);
  std::array<DirectionInfo, 6> out;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 axis = axes.col(static_cast<int>(k));
    const Vec3 axis_body = R_odom_body.transpose() * axis;
    const Support support = support_along(axis, planes, settings.cluster_m);
    const bool supported =
        support.planes >= settings.support_planes && support.clusters >= settings.support_clusters;
    const double kappa = supported ? settings.kappa_supported : settings.kappa;
    out[k] = direction(axis, axis, I_t, I.block<3, 3>(3, 3), chance_t[k].mean,
                       chance_t[k].at_most(kappa, settings.lidar_alone));
    if (settings.lidar_alone && !supported) {
      out[k].information = 0.0;
      out[k].sigma = std::numeric_limits<double>::infinity();
    }
    out[k].planes = support.planes;
    out[k].clusters = support.clusters;
    out[k].category = category_of(out[k].sigma, settings.full_m, settings.none_m);
    out[k + 3] = direction(axis, axis_body, I_r, I.block<3, 3>(0, 0), chance_r[k].mean,
                           chance_r[k].at_most(settings.kappa, settings.lidar_alone));
    out[k + 3].category =
        category_of(out[k + 3].sigma, settings.full_deg * kDegree, settings.none_deg * kDegree);
  }
  return out;
}

void remove_spurious(Mat6& I, Vec6& b, const Mat3& R_odom_body,
                     std::span<const DirectionInfo, 6> directions) {
  for (std::size_t k = 0; k < 6; ++k) {
    const DirectionInfo& info = directions[k];
    if (info.raw <= 0.0 || info.information >= info.raw) continue;
    const int block = k < 3 ? 3 : 0;
    const int other = 3 - block;
    const Vec3 v =
        k < 3 ? info.direction_odom : Vec3(R_odom_body.transpose() * info.direction_odom);
    Vec6 u;
    u.segment<3>(block) = v;
    u.segment<3>(other) =
        -pseudo_inverse(I.block<3, 3>(other, other)) * I.block<3, 3>(other, block) * v;
    const Vec6 Iu = I * u;
    const double along = u.dot(Iu);
    if (along <= info.information || along <= 0.0) continue;
    const double remove = 1.0 - info.information / along;
    b -= remove / along * u.dot(b) * Iu;
    I -= remove / along * Iu * Iu.transpose();
  }
}

void CategoryFilter::apply(Report& report) {
  for (std::size_t k = 0; k < 6; ++k) {
    Track& track = tracks_[k];
    const Category now = report.directions[k].category;
    if (!track.started) {
      track = {now, 0, true};
    } else if (now == track.category) {
      track.pending = 0;
    } else {
      const bool worse = now > track.category;
      const int needed = worse ? settings_.scans_to_worse : settings_.scans_to_better;
      track.pending =
          (track.pending > 0) == worse ? track.pending + (worse ? 1 : -1) : (worse ? 1 : -1);
      if (std::abs(track.pending) >= needed) track = {now, 0, true};
    }
    report.directions[k].category = track.category;
  }
  report.degenerate = false;
  report.sigma_degenerate_m = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const DirectionInfo& info = report.directions[k];
    report.degenerate = report.degenerate || info.category == Category::kNone;
    if (k == 0 || info.sigma > report.sigma_degenerate_m) {
      report.sigma_degenerate_m = info.sigma;
      report.degenerate_odom = info.direction_odom;
    }
  }
}

}  // namespace rali::degeneracy
