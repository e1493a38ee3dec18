#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/settings.hpp"
#include "rali/degeneracy/paper_settings.hpp"
#include "rali/fleet/path/shape.hpp"
#include "rali/graph/settings.hpp"
#include "rali/odometry/settings.hpp"
#include "rali/ranging/settings.hpp"
#include "rali/sensor/calibration.hpp"
#include "rali/vehicle/peer_mask.hpp"

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

/// Which sweeps are nodes of the vehicle's path (path_recorder.hpp), besides keyframes.
struct PathSettings {
  double rest_s = 5.0;
  double drive_s = 1.0;

  template <class V>
  void visit(V& v) {
    v("standstill_s", rest_s, 0.5, 600.0, "time between nodes at standstill");
    v("drive_s", drive_s, 0.1, 60.0, "longest time between nodes while driving");
  }
};

/// What the vehicle tells the others (fact_writer.hpp).
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

/// The second look at a blind stretch (back_end.hpp).
struct BackEndSettings {
  bool use = true;
  int rounds = 3;
  int iterations = 20;
  double blind_min_m = 5.0;
  double path_sigma_m = 0.1;
  double start_speed_sigma_mps = 0.05;
  double start_gyro_bias_sigma_radps = 0.002;
  double start_accel_bias_sigma_mps2 = 0.05;
  fleet::ShapeSettings shape;
  graph::LocalGraphSettings graph;

  template <class V>
  void visit(V& v) {
    v("use", use, "keyframes of degenerate stretches are corrected by all ranges");
    v("rounds", rounds, 1, 20, "solutions, each with the ranges classified again");
    v("iterations", iterations, 1, 1000, "of each solution");
    v("degenerate_min_m", blind_min_m, 0.0, 1000.0,
      "smallest degenerate distance travelled that is solved");
    v("path_sigma_m", path_sigma_m, 0.0, 10.0,
      "sigma of the path when ranges are classified again");
    v("start_speed_sigma_mps", start_speed_sigma_mps, 1e-4, 100.0, "of the first variable");
    v("start_gyro_bias_sigma_radps", start_gyro_bias_sigma_radps, 1e-6, 1.0, "of the first");
    v("start_accel_bias_sigma_mps2", start_accel_bias_sigma_mps2, 1e-5, 10.0, "of the first");
    v.group("shape", shape, "what ties nodes together");
    v.group("graph", graph, "the solver");
  }
};

/// Everything one vehicle's software needs to know before its first event.
struct VehicleSettings {
  std::string name = "v1";
  sensor::Calibration calibration;
  std::vector<geometry::Vec3> antennas_body_m = {geometry::Vec3::Zero()};
  std::vector<PeerSettings> peers;
  ranging::RangingSettings ranging;
  PathSettings path;
  FactSettings facts;
  BackEndSettings back_end;
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
    v.group("back_end", back_end, "second solution of degenerate stretches");
    v.group("paper_degree", paper_degree, "the paper's detector of degenerate directions");
    v("paper_degree_downsample_m", paper_degree_downsample_m, 0.02, 5.0,
      "resolution of the features behind the paper's degree, in preset robust");
    v("imu_wait_s", imu_wait_s, 0.0, 5.0,
      "wait for late inertial data before a scan goes on without");
  }
};

}  // namespace rali::vehicle
