#pragma once

#include <span>
#include <vector>

#include "rali/imu/rest.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::odometry {

/// Means over blocks of 0.1 s: white noise of a good sensor at 200 Hz has more spread than slow
/// driving; the block means of that noise have less.
[[nodiscard]] std::vector<sensor::ImuSample> block_means(
    const std::vector<sensor::ImuSample>& samples);

/// Standard deviations, norms of the three axes.
struct Shaking {
  double accel_mps2 = 0.0, gyro_radps = 0.0;
};

/// Spread of samples about straight lines through their blocks of 0.1 s: noise and shaking, but
/// neither turns nor changes of speed.
[[nodiscard]] Shaking shaking(std::span<const sensor::ImuSample> samples);

/// No shaking and no start: the spread of the block means is that of a sensor at standstill. Steady
/// motion over a smooth floor looks the same; only the LiDAR distinguishes it.
/// @param blocks  statistics of block_means()
[[nodiscard]] bool is_quiet(const imu::ImuStatistics& blocks, const imu::RestSettings& settings);

/// The rates and forces contain no slow variation beyond noise: means over a tenth of the time vary
/// no more than expected from the means over 0.1 s within them (one-way analysis of variance, six
/// axes). This holds at standstill for a noisy sensor and on a running engine; a driving vehicle
/// steers, and floors are uneven.
/// @param blocks block_means() of 15 s: shorter ones do not reveal slow driving over a smooth floor
/// @param in_group_min blocks in a tenth of the time; fewer prove nothing
[[nodiscard]] bool is_only_noise(std::span<const sensor::ImuSample> blocks,
                                 std::size_t in_group_min = 10);

/// An idling engine: the samples shake, but their means over 0.1 s spread as those of noise or of a
/// tone, and do not vary slowly. Wheels move a vehicle at 0.5 to 10 Hz as well.
/// @param samples of kIdling_s
[[nodiscard]] bool is_idling(const std::vector<sensor::ImuSample>& samples);

inline constexpr double kIdling_s = 2.0;

/// The LiDAR proves motion: the displacement is longer than limit_m along an observable direction.
/// Along a degenerate one, its poses drift by metres at standstill.
/// @param covariance_m2  of the displacement, in its frame
[[nodiscard]] bool has_travelled(const geometry::Vec3& displacement_m,
                                 const geometry::Mat3& covariance_m2, double limit_m);

/// The LiDAR proves a turn: by more than 0.01 rad, and more than its uncertainty.
[[nodiscard]] bool has_turned(double turn_rad, double variance_rad2);

}  // namespace rali::odometry
