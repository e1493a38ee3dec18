#include "rali/drive/offset/mounting.hpp"

#include <algorithm>

#include <Eigen/Eigenvalues>

namespace rali::drive {

using geometry::Mat3;
using geometry::Vec3;

namespace {

constexpr double kMisfitMax_rad = 0.15;  ///< about 9 degrees, as in `rali doctor`
constexpr double kClearlyBetter = 0.4;   ///< fraction of the assumed rotation's misfit
/// With less turning about a second axis only the first is known.
constexpr double kSecondAxisMin = 0.1;

/// The axis about which the LiDAR turned most.
Vec3 main_axis(std::span<const imu::LidarTurn> lidar) {
  Mat3 sum = Mat3::Zero();
  for (const imu::LidarTurn& turn : lidar) {
    sum += turn.turn_lidar_rad * turn.turn_lidar_rad.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Mat3>(sum).eigenvectors().col(2);
}

}  // namespace

MountingByTurning judge_mounting(const Mat3& R_imu_lidar_assumed,
                                 std::span<const imu::LidarTurn> lidar,
                                 std::span<const sensor::ImuSample> imu,
                                 const imu::RotationStudy& study) {
  MountingByTurning out;
  out.R_imu_lidar = R_imu_lidar_assumed;
  if (study.gyro_ratio == 0.0) return out;
  if (study.second_axis_fraction >= kSecondAxisMin) {
    out.R_imu_lidar = study.best.R_imu_lidar;
  } else {
    const Vec3 axis_lidar = main_axis(lidar);
    out.R_imu_lidar = geometry::rotation_between(Vec3(R_imu_lidar_assumed * axis_lidar),
                                                 Vec3(study.best.R_imu_lidar * axis_lidar)) *
                      R_imu_lidar_assumed;
  }
  out.assumed_misfit_rad = imu::misfit_of(R_imu_lidar_assumed, lidar, imu, study);
  out.misfit_rad = imu::misfit_of(out.R_imu_lidar, lidar, imu, study);
  if (out.assumed_misfit_rad <= kMisfitMax_rad) {
    out.verdict = MountingVerdict::kAgrees;
  } else if (out.misfit_rad <= kMisfitMax_rad &&
             out.misfit_rad < kClearlyBetter * out.assumed_misfit_rad) {
    out.verdict = MountingVerdict::kContradicts;
  }
  return out;
}

}  // namespace rali::drive
