#pragma once

#include <optional>
#include <span>
#include <string>

#include "rali/base/finding.hpp"
#include "rali/drive/input/imu_check.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::inspect {

/// Results from the inertial data alone; values in SI after the estimated factors.
struct ImuStudy {
  double accel_scale = 1.0;  ///< to m/s^2
  double gyro_scale = 1.0;   ///< to rad/s
  bool units_known = true;   ///< false: gravity is not visible in the data
  bool rest_at_start = false;
  geometry::Vec3 up_imu = geometry::Vec3::UnitZ();  ///< against gravity, from the quietest period
  double up_sigma_rad = 0.2;                        ///< 1-sigma of up_imu
  double gyro_noise_radps_rthz = 0.0;               ///< at standstill
  double accel_noise_mps2_rthz = 0.0;
  double vibration_factor = 0.0;  ///< accelerometer while driving / at standstill; 0: not
                                  ///< observable
  std::uint64_t saturated = 0;
  std::uint64_t invalid = 0;
};

/// @param raw as in the file, in time order
/// @param R_body_imu as given; the identity if not
/// @param gyro_scale to rad/s, if known from LiDAR odometry; else determined from the values, which
/// a steady smooth bend can mislead (D09)
[[nodiscard]] ImuStudy study_imu(std::span<const sensor::ImuSample> raw, double period_s,
                                 std::optional<double> gyro_scale, const std::string& topic,
                                 FindingList& out,
                                 const geometry::Mat3& R_body_imu = geometry::Mat3::Identity());

}  // namespace rali::inspect
