#include "rali/vehicle/paper_detector.hpp"

namespace rali::vehicle {

using geometry::Vec3;

PaperDetector::PaperDetector(const VehicleSettings& settings)
    : settings_(settings.paper_degree.resolved(settings.odometry.paper.literal)),
      R_body_lidar_(settings.calibration.T_body_lidar.R) {
  feature_settings_.downsample_m = settings.paper_degree_downsample_m;
  feature_settings_.theta_planar_deg = settings.odometry.paper.theta_planar_deg;
}

degeneracy::PaperDegree PaperDetector::degree(const sensor::LidarScan& scan,
                                              const odometry::ScanResult& result,
                                              const Vec3& g_odom_mps2) {
  const Vec3 up_body = -(result.T_odom_body.R.transpose() * g_odom_mps2).normalized();
  if (!result.feature_normals_body.empty()) {
    return degeneracy::paper_degree(result.feature_normals_body, up_body, settings_);
  }
  normals_.clear();
  if (scan.has_rings) {
    // The scan is not undistorted: the distortion within the few decimetres between neighbours is
    // far below the angle that separates features from noise.
    extractor_.extract(odometry::paper::view_of(scan), feature_settings_, features_);
    for (std::size_t i = 0; i < features_.size(); ++i) {
      const Eigen::Vector3f n(features_.nx[i], features_.ny[i], features_.nz[i]);
      normals_.push_back(R_body_lidar_ * n.cast<double>());
    }
  }
  return degeneracy::paper_degree(normals_, up_body, settings_);
}

}  // namespace rali::vehicle
