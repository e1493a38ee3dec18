#include "rali/sim/sim_options.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "rali/sim/internal/range_check.hpp"

namespace rali::sim {

using geometry::Vec3;

sensor::Calibration sensor_mounting(bool imu_apart) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  sensor::Calibration c;
  c.T_body_lidar = {geometry::rotation_from_rpy(0.4 * kDegree, -0.6 * kDegree, 1.5 * kDegree),
                    Vec3(0.10, 0.0, 0.35)};
  if (!imu_apart) return c;
  c.T_body_imu = {geometry::rotation_from_rpy(0.0, 0.0, 90.0 * kDegree), Vec3(-0.05, 0.03, 0.08)};
  return c;
}

Vec3 random_direction(Rng& rng) {
  const double x = rng.normal();
  const double y = rng.normal();
  const double z = rng.normal();
  return Vec3(x, y, z).normalized();
}

sensor::Calibration measured_by_hand(const sensor::Calibration& truth, const SimOptions& o,
                                     std::uint64_t seed) {
  Rng rng(seed, "calibration");
  sensor::Calibration c = truth;
  c.T_body_lidar.p += o.calibration_error_m * random_direction(rng);
  const double angle = o.calibration_error_deg * std::numbers::pi / 180.0;
  c.T_body_lidar.R = c.T_body_lidar.R * geometry::so3_exp(angle * random_direction(rng));
  return c;
}

Crowd crowd_of(const SimOptions& options) {
  return {options.pedestrians, options.standing_people, options.crossing_people};
}

Status check_options(const SimOptions& options) {
  SimOptions o = options;
  RangeCheck check;
  o.motion.visit(check);
  o.ranging.visit(check);
  o.imu.visit(check);
  check("duration_s", o.duration_s, 0.0, 36000.0, "");
  check("pedestrians", o.pedestrians, 0.0, 1000.0, "");
  check("standing_people", o.standing_people, 0.0, 1000.0, "");
  check("crossing_people", o.crossing_people, 0.0, 1000.0, "");
  for (Escort& e : o.escorts) e.visit(check);
  check("calibration_error_m", o.calibration_error_m, 0.0, 1.0, "");
  check("calibration_error_deg", o.calibration_error_deg, 0.0, 45.0, "");
  check.choice("scene", o.scene, kSceneNames, "");
  check.choice("lidar", o.lidar, kLidarNames, "");
  if (o.ranging.resolution_m * 65535.0 < o.ranging.max_range_m && check.bad.empty()) {
    check.bad = "resolution_m";
  }
  if (o.start.ns < 0 || o.start.ns > 8'000'000'000'000'000'000) check.bad = "start";
  if (!check.bad.empty()) {
    return fail(ErrorCode::kUsage, check.bad, "this option of the simulation is outside its range",
                "`rali simulate --help` lists the ranges.");
  }
  return {};
}

}  // namespace rali::sim
