#include "rali/imu/mounting.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace rali::imu {

using geometry::Mat3;
using geometry::Vec3;

namespace {

constexpr double kOffMax_rad = 0.15;  ///< about 9 degrees
/// Beyond it the LiDAR's turns are noise, or were led astray by what it saw.
constexpr double kNoiseMax = 0.5;

/// The axis about which the LiDAR turned most.
Vec3 main_axis(std::span<const LidarTurn> lidar) {
  Mat3 sum = Mat3::Zero();
  for (const LidarTurn& turn : lidar) {
    sum += turn.turn_lidar_rad * turn.turn_lidar_rad.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Mat3>(sum).eigenvectors().col(2);
}

/// What a misfit has beyond a smaller one.
double beyond(double misfit_rad, double noise_rad) {
  return std::sqrt(std::max(0.0, misfit_rad * misfit_rad - noise_rad * noise_rad));
}

}  // namespace

MountingByTurning judge_mounting(const Mat3& R_imu_lidar_assumed, std::span<const LidarTurn> lidar,
                                 std::span<const sensor::ImuSample> samples,
                                 const RotationStudy& study) {
  MountingByTurning out;
  out.R_imu_lidar = R_imu_lidar_assumed;
  if (study.gyro_ratio == 0.0) return out;
  const Vec3 axis_lidar = main_axis(lidar);
  out.R_imu_lidar = geometry::rotation_between(Vec3(R_imu_lidar_assumed * axis_lidar),
                                               Vec3(study.best.R_imu_lidar * axis_lidar)) *
                    R_imu_lidar_assumed;
  out.assumed_misfit_rad = misfit_of(R_imu_lidar_assumed, lidar, samples, study);
  out.misfit_rad = misfit_of(out.R_imu_lidar, lidar, samples, study);
  const double best_misfit_rad = misfit_of(study.best.R_imu_lidar, lidar, samples, study);
  // The misfit of the best rotation is noise: only what exceeds it counts against another, and that
  // is known to `chance`.
  const double chance_rad =
      2.0 * best_misfit_rad * std::sqrt(3.0 / static_cast<double>(study.pairs));
  if (beyond(out.misfit_rad, best_misfit_rad) > 2.0 * chance_rad) {
    out.R_imu_lidar = study.best.R_imu_lidar;  // it has turned about a second axis, too
    out.misfit_rad = best_misfit_rad;
  }
  if (out.misfit_rad > kNoiseMax) return out;
  const double off_rad = beyond(out.assumed_misfit_rad, out.misfit_rad);
  if (off_rad > std::max(kOffMax_rad, 2.0 * chance_rad)) {
    out.verdict = MountingVerdict::kContradicts;
  } else if (off_rad + chance_rad <= kOffMax_rad) {
    out.verdict = MountingVerdict::kAgrees;
  }
  return out;
}

}  // namespace rali::imu
