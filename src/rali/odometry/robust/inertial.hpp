#pragma once

#include <array>
#include <deque>
#include <utility>
#include <vector>

#include "rali/odometry/deskew.hpp"
#include "rali/odometry/imu_noise.hpp"
#include "rali/odometry/robust/state.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::odometry {

/// By axis of the body.
struct ClippedAxes {
  std::array<bool, 3> gyro = {}, accel = {};

  [[nodiscard]] bool any() const {
    return gyro[0] || gyro[1] || gyro[2] || accel[0] || accel[1] || accel[2];
  }
};

/// Inertial samples not yet used, and the propagation of the filter over them.
class InertialBuffer {
 public:
  void add(const sensor::ImuSample& sample);

  /// Discards samples older than `t` (one before it is kept for interpolation).
  void drop_before(Time t);

  [[nodiscard]] bool empty() const { return samples_.empty(); }

  /// Measured values at time t, linear between samples, held beyond the ends. Needs a sample.
  [[nodiscard]] sensor::ImuSample at(Time t) const;

  /// Samples in [begin, end].
  [[nodiscard]] std::vector<sensor::ImuSample> between(Time begin, Time end) const;

  /// Longest interval without a sample within [begin, end], in seconds.
  [[nodiscard]] double longest_gap_s(Time begin, Time end) const;

  /// Axes on which a sample in [begin, end] is at the limit of its sensor's range: the true turn
  /// rate or acceleration exceeds the measured one.
  [[nodiscard]] ClippedAxes clipped(Time begin, Time end) const;

 private:
  /// One axis: its largest value, and how often values repeat exactly.
  struct Axis {
    double maximum = 0.0;
    double repeats = 1.0;  ///< fraction of values that repeat the one before
    int in_a_row = 0;
  };

  void watch_clipping(const sensor::ImuSample& sample);

  std::deque<sensor::ImuSample> samples_;
  std::deque<std::pair<Time, ClippedAxes>> clipped_;
  std::array<Axis, 6> axes_;  ///< gyro, accelerometer
};

/// Propagates to t_end sample by sample. Measured values are averaged over each interval, because a
/// sample at its start lags by half an interval in a jolt. Appends the pose after each step to
/// `poses`.
void propagate_over(FilterState& state, const InertialBuffer& buffer, Time t_end,
                    const ProcessNoise& noise, std::vector<TimedPose>& poses);

/// The integral of inertial data alone from one time to another: velocity and displacement from
/// force and gravity, in odom, and the rotation from the first body to the second.
struct InertialIntegral {
  geometry::Vec3 dv_mps = geometry::Vec3::Zero();
  geometry::Vec3 dp_m = geometry::Vec3::Zero();
  geometry::Mat3 dR = geometry::Mat3::Identity();
};

/// @param state attitude, biases and gravity at state.t, where the integral starts
[[nodiscard]] InertialIntegral integrate_from(const FilterState& state,
                                              const InertialBuffer& buffer, Time t_end);

}  // namespace rali::odometry
