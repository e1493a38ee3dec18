#include "rali/fleet/facts/quantise.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "rali/fleet/facts/rounding.hpp"
#include "rali/graph/root.hpp"

namespace rali::fleet {

namespace {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;

/// Error in a body; none if it is valid.
using Fault = std::optional<const char*>;

constexpr double kPlaceMax_m = 1e7;
constexpr double kRangeMax_m = 1e5;
constexpr double kNumberMax = 1e30;
constexpr double kWalkMin = 1e-30;  ///< representable as a float
const char* const kNoNumber = "holds a value that is not a number or out of all bounds";

template <class Matrix>
bool sane(const Matrix& m, double limit = kNumberMax) {
  return m.allFinite() && (m.size() == 0 || m.cwiseAbs().maxCoeff() <= limit);
}

/// R must be close to a rotation: else its quaternion is arbitrary.
bool sane(const SE3& T) {
  constexpr double kRotationError = 1e-3;
  return sane(T.p, kPlaceMax_m) && sane(T.R) &&
         (T.R.transpose() * T.R - Mat3::Identity()).cwiseAbs().maxCoeff() < kRotationError &&
         T.R.determinant() > 0.0;
}

Vec3 as_float(const Vec3& v) {
  return {rounded_float(v.x()), rounded_float(v.y()), rounded_float(v.z())};
}

Mat3 rounded(const Mat3& R) { return rotation_of(rotation_code(R, kPoseBits), kPoseBits); }

Fault round(EpochStart& start) {
  if (start.name.size() > kNameMax) return "has too long a name";
  if (start.antennas_body_m.size() > kAntennasMax) return "has too many antennas";
  for (const Vec3& antenna : start.antennas_body_m) {
    if (!sane(antenna, kPlaceMax_m)) return kNoNumber;
  }
  return std::nullopt;
}

Fault round(graph::InertialFactor& f) {
  constexpr double kDurationMax_s = 1e5;
  const bool ok = f.duration_s > 0.0 && f.duration_s < kDurationMax_s &&
                  sane(f.dv_mps, kPlaceMax_m) && sane(SE3{f.dR, f.dp_m}) &&
                  sane(f.gyro_bias_radps) && sane(f.accel_bias_mps2) && sane(f.d_rotation_d_gyro) &&
                  sane(f.d_velocity_d_gyro) && sane(f.d_velocity_d_accel) &&
                  sane(f.d_position_d_gyro) && sane(f.d_position_d_accel) && sane(f.covariance) &&
                  sane(f.g_odom_mps2) && sane(f.T_body_imu) && f.gyro_walk_radps_rts > kWalkMin &&
                  f.gyro_walk_radps_rts < kNumberMax && f.accel_walk_mps2_rts > kWalkMin &&
                  f.accel_walk_mps2_rts < kNumberMax;
  if (!ok) return kNoNumber;
  f.i = f.j = 0;
  f.dR = rounded(f.dR);
  for (Vec3* v : {&f.dv_mps, &f.dp_m, &f.gyro_bias_radps, &f.accel_bias_mps2, &f.g_odom_mps2,
                  &f.T_body_imu.p}) {
    *v = as_float(*v);
  }
  for (Mat3* m : {&f.d_rotation_d_gyro, &f.d_velocity_d_gyro, &f.d_velocity_d_accel,
                  &f.d_position_d_gyro, &f.d_position_d_accel}) {
    *m = scaled_of(scaled_code(*m));
  }
  f.covariance = covariance_of<9>(covariance_code<9>(f.covariance));
  f.gyro_walk_radps_rts = rounded_float(f.gyro_walk_radps_rts);
  f.accel_walk_mps2_rts = rounded_float(f.accel_walk_mps2_rts);
  f.T_body_imu.R = rounded(f.T_body_imu.R);
  return std::nullopt;
}

Fault round(Increment& step) {
  constexpr double kLevelMax_rad = 4.0;  // more than half a turn is no direction
  const bool ok = sane(step.T_odom_body) && sane(step.v_odom_mps) && sane(step.gyro_bias_radps) &&
                  sane(step.accel_bias_mps2) && sane(step.g_odom_mps2) && sane(step.covariance) &&
                  sane(step.lidar_information) && step.level_sigma_rad >= 0.0 &&
                  step.level_sigma_rad <= kLevelMax_rad && step.force_sigma_mps2 >= 0.0 &&
                  step.force_sigma_mps2 < kNumberMax;
  if (!ok) return kNoNumber;
  step.T_odom_body.R = rounded(step.T_odom_body.R);
  for (Vec3* v :
       {&step.v_odom_mps, &step.gyro_bias_radps, &step.accel_bias_mps2, &step.g_odom_mps2}) {
    *v = as_float(*v);
  }
  step.level_sigma_rad = rounded_float(step.level_sigma_rad);
  step.force_sigma_mps2 = rounded_float(step.force_sigma_mps2);
  step.covariance = covariance_of<6>(covariance_code<6>(step.covariance));
  step.lidar_information = rounded_information(step.lidar_information);
  if (!step.inertial) return std::nullopt;
  const Fault fault = round(*step.inertial);
  // After rounding, strongly correlated entries (velocity and position of a single sample) may no
  // longer form a covariance. Such a step adds nothing to the LiDAR's constraint.
  if (!fault && !graph::is_covariance(step.inertial->covariance)) step.inertial.reset();
  return fault;
}

Fault round(RangeBlock& block) {
  if (block.ranges.size() > kRangesMax) return "holds too many ranges";
  for (RangeEntry& range : block.ranges) {
    const bool ok = range.range_m >= 0.0 && range.range_m <= kRangeMax_m && range.sigma_m >= 0.0 &&
                    range.sigma_m <= kRangeMax_m && sane(range.T_odom_body);
    if (!ok) return kNoNumber;
    range.range_m = range_of(range_code(range.range_m));
    range.sigma_m = range_of(std::max<std::int64_t>(range_code(range.sigma_m), 1));
    range.T_odom_body.R = rotation_of(rotation_code(range.T_odom_body.R, kRangeBits), kRangeBits);
    for (int k = 0; k < 3; ++k) {
      range.T_odom_body.p[k] = range_of(range_code(range.T_odom_body.p[k]));
    }
  }
  std::stable_sort(block.ranges.begin(), block.ranges.end(),
                   [](const RangeEntry& a, const RangeEntry& b) { return a.t < b.t; });
  return std::nullopt;
}

Fault round(KeyframePoints& points) {
  if (points.size() > kPointsMax) return "holds too many points";
  if (!sane(points.T_body_lidar)) return kNoNumber;
  points.T_body_lidar.R = rounded(points.T_body_lidar.R);
  points.T_body_lidar.p = as_float(points.T_body_lidar.p);
  return std::nullopt;
}

Fault round(Loop& loop) {
  const bool ok = sane(loop.T_from_to) && sane(loop.information) && std::isfinite(loop.overlap) &&
                  std::isfinite(loop.rms_m) && std::abs(loop.overlap) < kNumberMax &&
                  std::abs(loop.rms_m) < kNumberMax;
  if (!ok) return kNoNumber;
  loop.T_from_to.R = rounded(loop.T_from_to.R);
  loop.information = rounded_information(loop.information);
  loop.overlap = rounded_float(loop.overlap);
  loop.rms_m = rounded_float(loop.rms_m);
  return std::nullopt;
}

Fault round(UnreadBody&) { return std::nullopt; }

}  // namespace

Result<Fact> quantised(const Fact& fact) {
  Fact out = fact;
  const Fault fault = std::visit([](auto& body) { return round(body); }, out.body);
  if (fault) {
    return fail(ErrorCode::kInput, text_of(fact.key), fmt::format("the fact {}", *fault),
                "It was not taken into the map of the fleet.");
  }
  return out;
}

std::size_t bytes_about(const Fact& fact) {
  // Measured on simulated keyframes: wire/fleet/README.md.
  constexpr std::size_t kFrame = 40, kIncrement = 400, kInertial = 350, kRange = 16, kPoint = 2;
  if (const auto* block = std::get_if<RangeBlock>(&fact.body)) {
    return kFrame + kRange * block->ranges.size() + fact.unread.size();
  }
  if (const auto* points = std::get_if<KeyframePoints>(&fact.body)) {
    const std::size_t intensity = points->points.has_intensity() ? points->size() / 3 : 0;
    return kFrame + kPoint * points->size() + intensity + fact.unread.size();
  }
  if (const auto* step = std::get_if<Increment>(&fact.body)) {
    return kIncrement + (step->inertial ? kInertial : 0) + fact.unread.size();
  }
  constexpr std::size_t kOther = 200;
  return kOther + fact.unread.size();
}

std::string text_of(const FactKey& key) {
  return fmt::format("vehicle {}, epoch {}, number {}", key.vehicle.value, key.epoch, key.seq);
}

}  // namespace rali::fleet
