#include "rali/degeneracy/information.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "rali/degeneracy/walls.hpp"

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

/// Information on the translation with the rotation marginalised (Schur complement).
/// @param free projector on the rotations of the body that are not known otherwise
Mat3 translation_information(const Mat6& I, const Mat3& free) {
  const Mat3 cross = I.block<3, 3>(3, 0) * free;
  const Mat3 turns = free * I.block<3, 3>(0, 0) * free;
  return I.block<3, 3>(3, 3) - cross * pseudo_inverse(turns) * cross.transpose();
}

/// Projector on the rotations without roll about the axial direction, which gravity determines.
Mat3 without_roll(const Vec3& axial_odom, const Mat3& R_odom_body) {
  const Vec3 roll_body = R_odom_body.transpose() * axial_odom;
  return Mat3::Identity() - roll_body * roll_body.transpose();
}

/// Rise per metre at which the scan sees motion along `axial` least: along an inclined passage, its
/// slope. If motion had to be horizontal, the ground would seem to constrain it.
/// @param I_t of translation_information() @param full_m a vertical less certain has no slope
double slope_along(const Vec3& axial, const Mat3& I_t, const Vec3& up, double full_m) {
  // In a level round pipe the normals' errors look like such a slope. So small a one changes the
  // information less than what is subtracted for chance.
  constexpr double kLevel = 0.03;
  const Vec3 I_up = I_t * up;
  const double slope = -axial.dot(I_up) / (up.dot(I_up) + 1.0 / (full_m * full_m));
  return std::abs(slope) > kLevel ? slope : 0.0;
}

/// The horizontal direction with least information. @param previous kept, made level, if none has
/// clearly less
Vec3 axial_azimuth(const Mat6& I, const Vec3& up, const Vec3& previous,
                   const AwareSettings& settings) {
  const Vec3 helper = std::abs(up.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 h1 = (helper - helper.dot(up) * up).normalized();
  const Vec3 h2 = up.cross(h1);
  const Mat3 I_t = translation_information(I, Mat3::Identity());
  const double a = h1.dot(I_t * h1);
  const double b = h1.dot(I_t * h2);
  const double c = h2.dot(I_t * h2);
  const double mean = 0.5 * (a + c);
  const double spread = std::hypot(0.5 * (a - c), b);
  if (mean + spread <= settings.axis_ratio_min * (mean - spread)) {
    const Vec3 level = previous - previous.dot(up) * up;
    return level.norm() < 1e-3 ? h1 : Vec3(level.normalized());
  }
  const double angle = 0.5 * std::atan2(-b, -0.5 * (a - c));  // of the smaller eigenvector
  const Vec3 axial = std::cos(angle) * h1 + std::sin(angle) * h2;
  return axial.dot(previous) < 0.0 ? Vec3(-axial) : axial;
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

/// Chance information on a motion (boxplus): a plane whose points move by m adds w m^T N m.
Chance chance_of(const Vec6& motion, std::span<const PlaneEvidence> planes,
                 const Mat3& R_odom_body) {
  const Vec3 turn_odom = R_odom_body * motion.head<3>();
  Chance chance;
  for (const PlaneEvidence& plane : planes) {
    const Vec3 moved = motion.tail<3>() + turn_odom.cross(plane.lever_odom_m);
    chance.add(plane.weight * moved.dot(plane.normal_covariance * moved));
  }
  return chance;
}

double sigma_of(double information) {
  return information > 0.0 ? 1.0 / std::sqrt(information) : std::numeric_limits<double>::infinity();
}

void set_translation(const Vec6& motion, std::span<const PlaneEvidence> planes,
                     const Mat3& R_odom_body, const AwareSettings& settings, DirectionInfo& info) {
  const Chance chance = chance_of(motion, planes, R_odom_body);
  const Support support = support_along(info.direction_odom, planes, settings.cluster_m);
  info.planes = support.planes;
  info.clusters = support.clusters;
  const bool supported =
      support.planes >= settings.support_planes && support.clusters >= settings.support_clusters;
  const bool trusted = supported && settings.trusts_support;
  const double kappa = trusted ? settings.kappa_supported : settings.kappa;
  info.noise = chance.mean;
  if (supported || !settings.lidar_alone) {
    info.information = std::max(0.0, info.raw - chance.at_most(kappa, settings.lidar_alone));
  }
  if (trusted && sigma_of(info.information) > settings.full_m) {
    const WallHold walls = walls_facing(motion, planes, R_odom_body);
    // The system may have been freed along the motion, although its planes face it.
    const double of_walls = std::min(walls.raw, info.raw) - settings.kappa * walls.noise;
    if (of_walls > info.information) {
      info.information = of_walls;
      info.wall_residual_m = walls.residual_m;
    }
  }
  info.sigma = sigma_of(info.information);
  info.category = category_of(info.sigma, settings.full_m, settings.none_m);
}

/// Chance explains as large a fraction of the information as it does with the position held.
/// @param chance of the rotation with the position held @param held the information then
void set_rotation(const Chance& chance, double held, const AwareSettings& settings,
                  DirectionInfo& info) {
  const double fraction = held > 0.0 ? info.raw / held : 0.0;
  info.noise = fraction * chance.mean;
  info.information =
      std::max(0.0, info.raw - fraction * chance.at_most(settings.kappa, settings.lidar_alone));
  info.sigma = sigma_of(info.information);
  info.category = category_of(info.sigma, settings.full_deg * kDegree, settings.none_deg * kDegree);
}

}  // namespace

Axes physical_axes(const Mat6& I, const Vec3& g_odom_mps2, const Mat3& R_odom_body,
                   const Axes& previous, const AwareSettings& settings) {
  const Vec3 up = -g_odom_mps2.normalized();
  const Vec3 axial = axial_azimuth(I, up, previous.col(0), settings);
  const Mat3 I_t = translation_information(I, without_roll(axial, R_odom_body));
  Axes axes;
  axes.col(0) = (axial + slope_along(axial, I_t, up, settings.full_m) * up).normalized();
  axes.col(1) = up.cross(axial);
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

Vec6 least_motion(const Mat6& I, std::size_t k, const Mat3& R_odom_body, const Axes& axes) {
  const Vec3 direction = axes.col(static_cast<int>(k % 3));
  const Mat3 R_body_odom = R_odom_body.transpose();
  Vec6 u;
  if (k < 3) {
    const Mat3 free = without_roll(axes.col(0), R_odom_body);
    const Mat3 I_free = free * I.block<3, 3>(0, 0) * free;
    u.tail<3>() = direction;
    u.head<3>() = -pseudo_inverse(I_free) * free * I.block<3, 3>(0, 3) * direction;
  } else {
    u.head<3>() = R_body_odom * direction;
    u.tail<3>() = -pseudo_inverse(I.block<3, 3>(3, 3)) * I.block<3, 3>(3, 0) * u.head<3>();
  }
  return u;
}

std::array<DirectionInfo, 6> direction_information(const Mat6& I,
                                                   std::span<const PlaneEvidence> planes,
                                                   const Mat3& R_odom_body, const Axes& axes,
                                                   const AwareSettings& settings) {
  std::array<DirectionInfo, 6> out;
  for (std::size_t k = 0; k < 6; ++k) {
    DirectionInfo& info = out[k];
    info.direction_odom = axes.col(static_cast<int>(k % 3));
    const Vec6 u = least_motion(I, k, R_odom_body, axes);
    info.raw = std::max(0.0, u.dot(I * u));
    if (k < 3) {
      set_translation(u, planes, R_odom_body, settings, info);
    } else {
      Vec6 turn = u;
      turn.tail<3>().setZero();
      set_rotation(chance_of(turn, planes, R_odom_body), turn.dot(I * turn), settings, info);
    }
  }
  return out;
}

void remove_spurious(Mat6& I, Vec6& b, const Mat3& R_odom_body,
                     std::span<const DirectionInfo, 6> directions) {
  Axes axes;
  for (int k = 0; k < 3; ++k) axes.col(k) = directions[static_cast<std::size_t>(k)].direction_odom;
  for (std::size_t k = 0; k < 6; ++k) {
    const DirectionInfo& info = directions[k];
    if (info.raw <= 0.0 || info.information >= info.raw) continue;
    const Vec6 u = least_motion(I, k, R_odom_body, axes);
    const Vec6 Iu = I * u;
    const double along = u.dot(Iu);
    if (along <= info.information || along <= 0.0) continue;
    const double remove = 1.0 - info.information / along;
    const double residual_m = info.wall_residual_m.value_or(u.dot(b) / along);
    b += (info.information * residual_m - u.dot(b)) / along * Iu;
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
