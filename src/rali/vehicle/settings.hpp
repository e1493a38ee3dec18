#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/settings.hpp"
#include "rali/degeneracy/paper_settings.hpp"
#include "rali/fleet/path/shape.hpp"
#include "rali/odometry/settings.hpp"
#include "rali/ranging/settings.hpp"
#include "rali/sensor/calibration.hpp"
#include "rali/vehicle/peer_mask.hpp"

namespace rali::vehicle {

/// Start pose of a peer, measured by hand: its first pose in the own first pose, both levelled and
/// with their headings along x.
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
      bias_m;  ///< of ranges between the two, as given by the user; else estimated
};

/// Which scans are nodes of the vehicle's path (path_recorder.hpp), besides keyframes.
struct PathSettings {
  double rest_s = 5.0;
  double drive_s = 1.0;

  template <class V>
  void visit(V& v) {
    v("standstill_s", rest_s, 0.5, 600.0, "time between nodes at standstill");
    v("drive_s", drive_s, 0.1, 60.0, "longest time between nodes while driving");
  }
};

/// What the vehicle sends to the others (fact_writer.hpp).
struct FactSettings {
  std::uint32_t epoch = 0;  ///< raised at each start of the odometry
  double range_block_s = 1.0;
  double spacing_m = 0.2;

  template <class V>
  void visit(V& v) {
    v("range_block_s", range_block_s, 0.1, 60.0, "ranges of so long are one message");
    v("spacing_m", spacing_m, 0.02, 5.0, "between the points of a keyframe that others get");
  }
};

/// Everything that one vehicle's software needs before its first event.
struct VehicleSettings {
  std::string name = "v1";
  sensor::Calibration calibration;
  std::vector<geometry::Vec3> antennas_body_m = {geometry::Vec3::Zero()};
  std::vector<PeerSettings> peers;
  ranging::RangingSettings ranging;
  PathSettings path;
  FactSettings facts;
  PeerMaskSettings peer_mask;
  bool has_imu = true;  ///< false: LiDAR only, no scan waits for inertial data
  odometry::OdometrySettings odometry;
  degeneracy::PaperDegreeSettings paper_degree;
  double paper_degree_downsample_m = 0.2;  ///< of the features behind it, in preset robust
  double imu_wait_s =
      0.2;  ///< how long (data time) a scan waits for inertial data before it goes on without

  template <class V>
  void visit(V& v) {
    v.group("peer_mask", peer_mask, "other vehicles in view");
    v.group("path", path, "nodes of the path");
    v.group("facts", facts, "what is sent to other vehicles");
    v.group("paper_degree", paper_degree, "the paper's detector of degenerate directions");
    v("paper_degree_downsample_m", paper_degree_downsample_m, 0.02, 5.0,
      "resolution of the features behind the paper's degree, in preset robust");
    v("imu_wait_s", imu_wait_s, 0.0, 5.0,
      "wait for late inertial data before a scan goes on without");
  }
};

}  // namespace rali::vehicle
