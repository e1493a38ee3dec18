#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/settings.hpp"
#include "rali/degeneracy/paper_settings.hpp"
#include "rali/odometry/settings.hpp"
#include "rali/ranging/settings.hpp"
#include "rali/sensor/calibration.hpp"

namespace rali::vehicle {

/// Where a peer stood at the start, measured by hand: its first pose in the own first pose, both
/// levelled and with their headings along x.
struct PeerPrior {
  geometry::SE3 T_self_peer;
  double sigma_m = 0.2;
  double sigma_rad = 0.05;
};

/// Another vehicle of the fleet.
struct PeerSettings {
  VehicleId id;
  std::string name;
  std::vector<geometry::Vec3> antennas_body_m;  ///< in the peer's body
  std::optional<PeerPrior> prior;
  std::optional<double>
      bias_m;  ///< of ranges between the two, as the user knows it; else estimated
};

/// Everything one vehicle's software needs to know before its first event.
struct VehicleSettings {
  std::string name = "v1";
  sensor::Calibration calibration;
  std::vector<geometry::Vec3> antennas_body_m = {geometry::Vec3::Zero()};
  std::vector<PeerSettings> peers;
  ranging::RangingSettings ranging;
  bool has_imu = true;  ///< false: LiDAR only, no scan waits for inertial data
  odometry::OdometrySettings odometry;
  degeneracy::PaperDegreeSettings paper_degree;
  double paper_degree_downsample_m = 0.2;  ///< of the features behind it, in preset robust
  double imu_wait_s =
      0.2;  ///< how long (data time) a scan waits for inertial data before it goes on without

  template <class V>
  void visit(V& v) {
    v.group("paper_degree", paper_degree, "the paper's detector of blind directions");
    v("paper_degree_downsample_m", paper_degree_downsample_m, 0.02, 5.0,
      "resolution of the features behind the paper's degree, in preset robust");
    v("imu_wait_s", imu_wait_s, 0.0, 5.0,
      "wait for late inertial data before a scan goes on without");
  }
};

}  // namespace rali::vehicle
