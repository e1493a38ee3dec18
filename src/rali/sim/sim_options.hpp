#pragma once

#include <vector>

#include "rali/base/result.hpp"
#include "rali/sensor/calibration.hpp"
#include "rali/sim/imu_model.hpp"
#include "rali/sim/lidar_sensor.hpp"
#include "rali/sim/motion.hpp"
#include "rali/sim/pedestrians.hpp"
#include "rali/sim/world.hpp"

namespace rali::sim {

/// One vehicle and its sensors. Same options: same bytes.
struct SimOptions {
  Scene scene = Scene::kLoop;
  std::uint64_t seed = 1;  ///< changes scene, motion and noise
  Lidar lidar = Lidar::kRs16;
  double duration_s = 0.0;  ///< 0: the whole route; longer: at standstill at its end
  int pedestrians = 0;      ///< walking to and fro along the route
  int standing_people = 0;  ///< standing beside it
  int crossing_people = 0;  ///< crossing it from side to side
  std::vector<Escort> escorts;
  Time start = Time::from_ns(1'700'000'000'000'000'000);
  bool with_lidar = true;
  bool with_imu = true;
  bool imu_apart = false;  ///< false: body = IMU; true: turned by 90 deg, 10 cm beside the body
  double calibration_error_m = 0.002;  ///< of the nominal T_body_lidar, random direction
  double calibration_error_deg = 0.05;
  MotionOptions motion;
  LidarOptions ranging;
  ImuOptions imu;
};

/// The people configured by these options.
[[nodiscard]] Crowd crowd_of(const SimOptions& options);

/// Checks that every number is in the range declared by visit(). Errors (kUsage) name the option.
[[nodiscard]] Status check_options(const SimOptions& options);

/// Mounting of the sensors on the simulated vehicle: LiDAR ahead and up with a small rotation. With
/// imu_apart the IMU is turned by 90 deg, so that ignoring the extrinsic calibration shows.
[[nodiscard]] sensor::Calibration sensor_mounting(bool imu_apart);

/// A calibration as measured by a user: with the options' errors in random directions.
[[nodiscard]] sensor::Calibration measured_by_hand(const sensor::Calibration& truth,
                                                   const SimOptions& options, std::uint64_t seed);

/// A random direction.
[[nodiscard]] geometry::Vec3 random_direction(Rng& rng);

}  // namespace rali::sim
