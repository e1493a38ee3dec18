#pragma once

#include <span>
#include <vector>

#include "rali/imu/rest.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::odometry {

/// Means over blocks of 0.1 s: white noise of a good sensor at 200 Hz has more spread than slow
/// driving, its block means have not.
[[nodiscard]] std::vector<sensor::ImuSample> block_means(
    const std::vector<sensor::ImuSample>& samples);

/// Nothing shakes or starts: the spread of block means is that of a sensor that stands. Steady
/// motion over a smooth floor looks the same; the LiDAR has to tell.
/// @param blocks  statistics of block_means()
[[nodiscard]] bool is_quiet(const imu::ImuStatistics& blocks, const imu::RestSettings& settings);

/// The rates and forces hold nothing slow but noise: means over a tenth of the time vary no more
/// than the means over 0.1 s within them let expect (one-way analysis of variance, six axes). That
/// is what a noisy sensor shows at standstill, and one on a running engine; who drives steers, and
/// floors are uneven.
/// @param blocks  block_means() of 15 s: shorter ones do not tell slow driving over a smooth floor
[[nodiscard]] bool is_only_noise(std::span<const sensor::ImuSample> blocks);

/// The LiDAR proves motion: the displacement is longer than limit_m along a direction in which the
/// LiDAR knows where it is. Where it is blind, its poses slide by metres while nothing moves.
/// @param covariance_m2  of the displacement, in its frame
[[nodiscard]] bool has_travelled(const geometry::Vec3& displacement_m,
                                 const geometry::Mat3& covariance_m2, double limit_m);

/// The LiDAR proves a turn: by more than 0.01 rad, and more than it may be wrong.
[[nodiscard]] bool has_turned(double turn_rad, double variance_rad2);

}  // namespace rali::odometry
