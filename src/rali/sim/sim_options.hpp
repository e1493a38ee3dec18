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
  std::uint64_t seed = 1;  ///< changes place, motion and noise
  Lidar lidar = Lidar::kRs16;
  double duration_s = 0.0;  ///< 0: the whole route; longer: standing at its end
  int pedestrians = 0;      ///< who walk to and fro along the route
  int standing_people = 0;  ///< beside it
  int crossing_people = 0;  ///< from side to side of it
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

/// The people of these options.
[[nodiscard]] Crowd crowd_of(const SimOptions& options);

/// Every number within the range that visit() declares. Errors (kUsage) name the option.
[[nodiscard]] Status check_options(const SimOptions& options);

/// Where the sensors sit on the simulated vehicle: LiDAR ahead and up with a small turn. An IMU
/// apart is turned by 90 deg, so that a forgotten extrinsic shows.
[[nodiscard]] sensor::Calibration sensor_mounting(bool imu_apart);

/// A calibration as a user would write it down: off by the options' errors in random directions.
[[nodiscard]] sensor::Calibration measured_by_hand(const sensor::Calibration& truth,
                                                   const SimOptions& options, std::uint64_t seed);

/// A random direction.
[[nodiscard]] geometry::Vec3 random_direction(Rng& rng);

}  // namespace rali::sim
