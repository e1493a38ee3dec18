#pragma once

#include <deque>
#include <vector>

#include "rali/odometry/deskew.hpp"
#include "rali/odometry/imu_noise.hpp"
#include "rali/odometry/robust/state.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::odometry {

/// Inertial samples not yet used, and the propagation of the filter over them.
class InertialBuffer {
 public:
  void add(const sensor::ImuSample& sample);

  /// Forgets what is older than `t` (one sample before it is kept for interpolation).
  void drop_before(Time t);

  [[nodiscard]] bool empty() const { return samples_.empty(); }

  /// Measured values at time t, linear between samples, held beyond the ends. Needs a sample.
  [[nodiscard]] sensor::ImuSample at(Time t) const;

  /// Samples in [begin, end].
  [[nodiscard]] std::vector<sensor::ImuSample> between(Time begin, Time end) const;

  /// Longest stretch without a sample within [begin, end], in seconds.
  [[nodiscard]] double longest_gap_s(Time begin, Time end) const;

 private:
  std::deque<sensor::ImuSample> samples_;
};

/// Propagates to t_end sample by sample; measured values are averaged over each interval, because
/// a sample at its start lags by half an interval when the vehicle jolts. Appends the pose after
/// each step to `poses`.
void propagate_over(FilterState& state, const InertialBuffer& buffer, Time t_end,
                    const ImuNoiseSettings& noise, std::vector<TimedPose>& poses);

}  // namespace rali::odometry
