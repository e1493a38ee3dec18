#pragma once

#include <vector>

#include "rali/degeneracy/paper_degree.hpp"
#include "rali/odometry/odometry.hpp"
#include "rali/odometry/paper/planar_features.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::vehicle {

/// Computes the paper's degree of degeneracy on every scan, with any odometry. Preset `paper`
/// delivers the normals of its features; for the others they are extracted here by the same rule.
class PaperDetector {
 public:
  explicit PaperDetector(const VehicleSettings& settings);

  /// Unknown for a sensor without rings, unless the odometry delivers normals (preset `paper`).
  [[nodiscard]] degeneracy::PaperDegree degree(const sensor::LidarScan& scan,
                                               const odometry::ScanResult& result,
                                               const geometry::Vec3& g_odom_mps2);

 private:
  degeneracy::PaperDegreeSettings settings_;
  odometry::paper::PlanarFeatureSettings feature_settings_;
  geometry::Mat3 R_body_lidar_;
  odometry::paper::PlanarFeatureExtractor extractor_;
  odometry::paper::PlanarFeatures features_;
  std::vector<geometry::Vec3> normals_;
};

}  // namespace rali::vehicle
