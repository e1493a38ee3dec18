#include "rali/vehicle/pose_report.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace rali::vehicle {

namespace {

PoseQuality quality_of(odometry::TrackState state) {
  switch (state) {
    case odometry::TrackState::kGood:
      return PoseQuality::kGood;
    case odometry::TrackState::kWeak:
      return PoseQuality::kWeak;
    case odometry::TrackState::kDiverged:
      return PoseQuality::kDiverged;
    case odometry::TrackState::kWaiting:
    case odometry::TrackState::kPredicted:
      break;
  }
  return PoseQuality::kPredicted;
}

}  // namespace

PoseEstimate pose_of(VehicleId self, const odometry::ScanResult& result) {
  PoseEstimate pose;
  pose.vehicle = self;
  pose.t = result.t;
  pose.T_local_body = result.T_odom_body;
  pose.v_odom_mps = result.v_odom_mps;
  pose.covariance = result.covariance;
  pose.quality = quality_of(result.state);
  pose.at_rest = result.at_rest;
  pose.matches = result.matches;
  pose.residual_rms_m = result.residual_rms_m;
  return pose;
}

double level_sigma_rad(const geometry::Vec3& g_mps2, const geometry::Mat3& covariance_m2ps4) {
  const Eigen::SelfAdjointEigenSolver<geometry::Mat3> solver(covariance_m2ps4,
                                                             Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[2])) / g_mps2.norm();
}

degeneracy::Report degeneracy_of(const odometry::ScanResult& result,
                                 const odometry::OdometrySettings& settings,
                                 const geometry::Vec3& g_odom_mps2, degeneracy::Axes& axes) {
  degeneracy::Report report;
  const degeneracy::AwareSettings& aware = settings.robust.aware;
  if (result.directions) {
    report.directions = *result.directions;
  } else {
    axes = degeneracy::physical_axes(result.lidar_information, g_odom_mps2, result.T_odom_body.R,
                                     axes, aware);
    report.directions = degeneracy::direction_information(result.lidar_information, result.planes,
                                                          result.T_odom_body.R, axes, aware);
  }
  return report;
}

}  // namespace rali::vehicle
