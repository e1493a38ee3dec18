#include "rali/drive/input/imu_intake.hpp"

#include <cmath>

namespace rali::drive {
namespace {

/// No vehicle's IMU measures beyond 200 g and 5000 deg/s: a damaged message.
constexpr double kAbsurdAccel = 2000.0;
constexpr double kAbsurdGyro = 5000.0;
/// Repeated values below these are quantisation steps of the converter, not its full scale.
constexpr double kFullScaleAccel_mps2 = 19.0;
constexpr double kFullScaleGyro_radps = 2.0;

/// One axis at full scale: the largest value so far, exactly the same as in the previous sample.
bool is_stuck(double value, double last, double& maximum, double full_scale) {
  const double size = std::abs(value);
  const bool stuck = size >= full_scale && size >= maximum && value == last;
  if (size > maximum) maximum = size;
  return stuck;
}

}  // namespace

bool is_plausible(const sensor::ImuSample& raw) {
  return raw.accel_mps2.allFinite() && raw.gyro_radps.allFinite() &&
         raw.accel_mps2.cwiseAbs().maxCoeff() < kAbsurdAccel &&
         raw.gyro_radps.cwiseAbs().maxCoeff() < kAbsurdGyro;
}

std::optional<sensor::ImuSample> ImuIntake::take(const sensor::ImuSample& raw, InputGaps& gaps) {
  if (!is_plausible(raw)) {
    ++gaps.imu_invalid;
    return std::nullopt;
  }
  sensor::ImuSample si;
  si.t = raw.t;
  si.gyro_radps = units_.gyro_scale * raw.gyro_radps;
  si.accel_mps2 = units_.accel_scale * raw.accel_mps2;
  count_saturation(si, gaps);
  return si;
}

void ImuIntake::count_saturation(const sensor::ImuSample& si, InputGaps& gaps) {
  bool stuck = false;
  for (int axis = 0; axis < 3; ++axis) {
    stuck |=
        is_stuck(si.accel_mps2[axis], last_accel_[axis], max_accel_[axis], kFullScaleAccel_mps2);
    stuck |= is_stuck(si.gyro_radps[axis], last_gyro_[axis], max_gyro_[axis], kFullScaleGyro_radps);
  }
  if (stuck) ++gaps.imu_saturated;
  last_accel_ = si.accel_mps2;
  last_gyro_ = si.gyro_radps;
}

}  // namespace rali::drive
