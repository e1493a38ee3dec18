#pragma once

#include "rali/base/settings.hpp"
#include "rali/degeneracy/information.hpp"
#include "rali/imu/motion_noise.hpp"
#include "rali/imu/rest.hpp"
#include "rali/odometry/robust/coarse_search.hpp"
#include "rali/odometry/robust/drift.hpp"
#include "rali/odometry/robust/matcher.hpp"
#include "rali/odometry/robust/plane_map.hpp"

namespace rali::odometry {

/// Which points of a scan are used: one per bundle of rays, whose width gives the wanted number in
/// narrow and wide places alike.
struct SamplingSettings {
  int update_points = 1500;
  int insert_points = 6000;
  double spacing_min_m = 0.02;
  double spacing_max_m = 1.0;

  template <class V>
  void visit(V& v) {
    v("update_points", update_points, 100, 1000000, "points of a scan that correct the pose");
    v("insert_points", insert_points, 100, 1000000, "points of a scan that go into the map");
    v("spacing_min_m", spacing_min_m, 0.001, 1.0, "points are never closer");
    v("spacing_max_m", spacing_max_m, 0.05, 10.0, "points are never wider apart");
  }
};

/// The iterated update (algorithms 2.4).
struct UpdateSettings {
  int iterations_max = 5;
  double stop_m = 0.0005;
  double stop_deg = 0.005;
  double rematch_m = 0.02;
  int matches_min = 15;
  double straight_m = 0.3;
  double shift_slope = 0.02;
  double jolt_nis = 40.0;

  template <class V>
  void visit(V& v) {
    v("iterations_max", iterations_max, 1, 50, "iterations of one update");
    v("stop_m", stop_m, 1e-6, 0.1, "stop when the step is shorter");
    v("stop_deg", stop_deg, 1e-5, 1.0, "and turns less");
    v("rematch_m", rematch_m, 0.0, 1.0, "search correspondences again after a longer step");
    v("matches_min", matches_min, 6, 10000, "fewer matches: the scan is not used");
    v("straight_m", straight_m, 0.0, 1000.0, "ranges may shift the pose so far along a passage");
    v("shift_slope", shift_slope, 0.0, 1.0, "and beyond it is off across by so much per metre");
    v("jolt_nis", jolt_nis, 10.0, 1e6, "LiDAR and prediction differ by so much: a jolt was missed");
  }
};

/// Motion without inertial data (algorithms 2.7).
struct ConstantVelocitySettings {
  double accel_mps2_rthz = 1.0;
  double rate_radps2_rthz = 1.0;
  double start_speed_mps = 3.0;
  double start_rate_radps = 0.5;

  template <class V>
  void visit(V& v) {
    v("accel_mps2_rthz", accel_mps2_rthz, 0.01, 100.0, "how fast the velocity may change");
    v("rate_radps2_rthz", rate_radps2_rthz, 0.01, 100.0, "how fast the turn rate may change");
    v("start_speed_mps", start_speed_mps, 0.01, 100.0, "sigma of the speed at the first scan");
    v("start_rate_radps", start_rate_radps, 0.01, 20.0, "sigma of the turn rate at the first scan");
  }
};

/// How gravity and biases are initialised (algorithms 1.4).
struct InitialisationSettings {
  imu::RestSettings rest;
  double window_s = 1.0;
  int scans_min = 10;
  double give_up_s = 15.0;
  double rest_travel_max_m = 0.10;
  double still_accel_sd_max_mps2 = 0.2;
  double still_speed_sigma_mps = 0.05;
  double gyro_bias_sigma_radps = 0.015;
  double accel_bias_sigma_mps2 = 0.15;
  double gravity_mps2 = 9.81;

  template <class V>
  void visit(V& v) {
    v.group("standstill", rest, "detection of standstill");
    v("window_s", window_s, 0.2, 60.0, "data needed before gravity is solved for");
    v("scans_min", scans_min, 3, 1000, "scans needed before gravity is solved for");
    v("give_up_s", give_up_s, 1.0, 600.0, "after this the best guess of gravity is taken");
    v("standstill_travel_max_m", rest_travel_max_m, 1e-3, 1.0,
      "more motion by LiDAR is no standstill");
    v("standstill_accel_sd_max_mps2", still_accel_sd_max_mps2, 0.0, 10.0,
      "spread of samples at standstill: degenerate directions do not move");
    v("standstill_speed_sigma_mps", still_speed_sigma_mps, 1e-3, 10.0, "sigma of the speed then");
    v("gyro_bias_sigma_radps", gyro_bias_sigma_radps, 1e-5, 1.0,
      "turn-on bias of the gyro, 1 sigma; beyond 3 sigma it is noise");
    v("accel_bias_sigma_mps2", accel_bias_sigma_mps2, 1e-4, 5.0,
      "turn-on bias of the accelerometer, 1 sigma; beyond 3 sigma it is noise");
    v("gravity_mps2", gravity_mps2, 9.7, 9.9, "norm of gravity");
  }
};

/// Carrier of the sensors. It sets the defaults of ConstraintSettings (config/presets.cpp).
enum class Carrier { kGround, kHandheld, kDrone };
inline constexpr ChoiceNames<3> kCarrierNames{"ground", "handheld", "drone"};

/// Constraints on the motion of the carrier, with the defaults of ground vehicles; non_holonomic
/// and ground switch themselves off where they do not hold.
struct ConstraintSettings {
  bool standstill = true;
  bool non_holonomic = true;
  bool ground = true;
  double rest_after_s = 0.7;
  double speed_max_mps = 40.0;
  double accel_max_mps2 = 8.0;
  double speed_usual_mps = 2.0;

  template <class V>
  void visit(V& v) {
    v("standstill", standstill, "zero-velocity update at standstill");
    v("non_holonomic", non_holonomic,
      "no motion sideways or off the ground, once the data have shown that it holds");
    v("ground", ground, "constant height above ground, once the data have shown that it holds");
    v("standstill_after_s", rest_after_s, 0.2, 10.0,
      "length of the standstill before the zero-velocity update");
    v("speed_max_mps", speed_max_mps, 0.1, 300.0,
      "largest possible speed: above it the pose is lost [m/s]");
    v("accel_max_mps2", accel_max_mps2, 0.1, 1000.0,
      "largest possible mean acceleration over a second: above it the pose is lost");
    v("speed_usual_mps", speed_usual_mps, 0.1, 300.0,
      "sigma of the speed where nothing measures it");
  }
};

/// When a scan becomes a keyframe.
struct KeyframeSettings {
  double distance_m = 0.5;
  double angle_deg = 20.0;
  double voxel_m = 0.05;

  template <class V>
  void visit(V& v) {
    v("distance_m", distance_m, 0.01, 100.0, "distance travelled between keyframes [m]");
    v("angle_deg", angle_deg, 1.0, 180.0, "or rotation between keyframes [deg]");
    v("voxel_m", voxel_m, 0.0, 1.0, "one point per voxel is kept; 0 keeps all");
  }
};

/// Settings of preset `robust`.
struct RobustSettings {
  Carrier carrier = Carrier::kGround;
  double range_sigma_m = 0.0;
  double mounting_sigma_deg = 0.03;
  SamplingSettings sampling;
  MatchSettings match;
  UpdateSettings update;
  PlaneMapSettings map;
  degeneracy::AwareSettings aware;
  ConstantVelocitySettings constant_velocity;
  CoarseSearchSettings search;
  InitialisationSettings initialisation;
  ConstraintSettings constraints;
  KeyframeSettings keyframe;
  DriftSettings drift;
  imu::MotionNoiseSettings motion_noise;

  template <class V>
  void visit(V& v) {
    v.choice("carrier", carrier, kCarrierNames,
             "what carries the sensors: sets the defaults of constraints");
    v("range_sigma_m", range_sigma_m, 0.0, 1.0,
      "noise of a LiDAR range, 1 sigma [m]; 0: measured in the first scan");
    v("mounting_sigma_deg", mounting_sigma_deg, 0.0, 10.0,
      "sigma of the rotation in T_body_lidar, about each axis");
    v.group("sampling", sampling, "which points of a scan are used");
    v.group("match", match, "noise of points, outliers");
    v.group("update", update, "the iterated update");
    v.group("map", map, "planes in voxels");
    v.group("aware", aware, "noise-aware detector of degenerate directions");
    v.group("constant_velocity", constant_velocity, "motion model without inertial data");
    v.group("search", search, "search before an update without inertial data");
    v.group("initialisation", initialisation, "gravity and biases at the start");
    v.group("constraints", constraints, "how the carrier moves");
    v.group("keyframe", keyframe, "which scans become keyframes");
    v.group("drift", drift, "how the error grows with the distance travelled");
    v.group("motion_noise", motion_noise, "noise of inertial data while driving");
  }
};

}  // namespace rali::odometry
