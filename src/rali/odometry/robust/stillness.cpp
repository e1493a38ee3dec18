#include "rali/odometry/robust/stillness.hpp"

#include <cmath>

#include <Eigen/Cholesky>

namespace rali::odometry {

using geometry::Mat3;
using geometry::Vec3;
using sensor::ImuSample;

namespace {

constexpr std::int64_t kBlock_ns = 100'000'000;
constexpr double kSigmas = 3.0;  // beyond: it moves

}  // namespace

std::vector<ImuSample> block_means(const std::vector<ImuSample>& samples) {
  std::vector<ImuSample> out;
  std::size_t k = 0;
  std::size_t n_before = 0;
  while (k < samples.size()) {
    ImuSample mean{samples[k].t, Vec3::Zero(), Vec3::Zero()};
    std::size_t n = 0;
    while (k < samples.size() && samples[k].t.ns - mean.t.ns < kBlock_ns) {
      mean.gyro_radps += samples[k].gyro_radps;
      mean.accel_mps2 += samples[k].accel_mps2;
      ++k;
      ++n;
    }
    // A remainder of a sample or two at the end would bring back the noise that blocks average out.
    if (k == samples.size() && 2 * n < n_before) break;
    n_before = n;
    mean.gyro_radps /= static_cast<double>(n);
    mean.accel_mps2 /= static_cast<double>(n);
    out.push_back(mean);
  }
  return out;
}

namespace {

using Row6 = Eigen::Matrix<double, 6, 1>;

/// Squares about the straight line that fits a block best, gyro first.
Row6 squares_about_line(std::span<const ImuSample> block) {
  const double n = static_cast<double>(block.size());
  const auto row = [](const ImuSample& s) {
    return Row6((Row6() << s.gyro_radps, s.accel_mps2).finished());
  };
  const auto place = [n](std::size_t k) { return static_cast<double>(k) - 0.5 * (n - 1.0); };
  Row6 mean = Row6::Zero(), slope = Row6::Zero(), squares = Row6::Zero();
  for (const ImuSample& s : block) mean += row(s) / n;
  for (std::size_t k = 0; k < block.size(); ++k) slope += place(k) * row(block[k]);
  slope /= n * (n * n - 1.0) / 12.0;
  for (std::size_t k = 0; k < block.size(); ++k) {
    squares += (row(block[k]) - mean - place(k) * slope).cwiseAbs2();
  }
  return squares;
}

/// Variance of samples about straight lines through their blocks; zero if there are too few.
Row6 variance_within(std::span<const ImuSample> samples) {
  Row6 squares = Row6::Zero();
  double freedom = 0.0;
  for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
    while (end < samples.size() && samples[end].t.ns - samples[begin].t.ns < kBlock_ns) ++end;
    if (end - begin < 3) continue;
    squares += squares_about_line(samples.subspan(begin, end - begin));
    freedom += static_cast<double>(end - begin) - 2.0;
  }
  return freedom > 0.0 ? Row6(squares / freedom) : Row6(Row6::Zero());
}

}  // namespace

Shaking shaking(std::span<const ImuSample> samples) {
  const Row6 variance = variance_within(samples);
  return {std::sqrt(variance.tail<3>().sum()), std::sqrt(variance.head<3>().sum())};
}

bool is_quiet(const imu::ImuStatistics& blocks, const imu::RestSettings& settings) {
  // Axis by axis, because maxCoeff() ignores NaN.
  return (blocks.gyro_sd_radps.array() < settings.gyro_sd_max_radps).all() &&
         (blocks.accel_sd_mps2.array() < settings.accel_sd_max_mps2).all();
}

bool is_only_noise(std::span<const ImuSample> blocks, std::size_t in_group_min) {
  constexpr std::size_t kGroups = 10;
  constexpr double kAxisMax = 3.0;   // F of 9 and some 140 degrees of freedom: by chance 1 in 400
  constexpr double kMeanMax = 1.55;  // of six axes: 1 in 400
  const std::size_t n = blocks.size() / kGroups;
  if (n < in_group_min) return false;
  Row6 within = Row6::Zero(), sum = Row6::Zero(), squares = Row6::Zero();
  for (std::size_t g = 0; g < kGroups; ++g) {
    Row6 mean = Row6::Zero(), square = Row6::Zero();
    for (const ImuSample& s : blocks.subspan(g * n, n)) {
      const Row6 row = (Row6() << s.gyro_radps, s.accel_mps2 - blocks[0].accel_mps2).finished();
      mean += row / static_cast<double>(n);
      square += row.cwiseAbs2();
    }
    within += square - static_cast<double>(n) * mean.cwiseAbs2();
    sum += mean;
    squares += mean.cwiseAbs2();
  }
  const Row6 between =
      static_cast<double>(n) * (squares - sum.cwiseAbs2() / kGroups) / (kGroups - 1.0);
  const Row6 F = between.cwiseQuotient(within / static_cast<double>(kGroups * (n - 1)));
  // Axis by axis: a silent axis (0/0) or NaN proves nothing.
  return (F.array() < kAxisMax).all() && F.mean() < kMeanMax;
}

bool is_idling(const std::vector<ImuSample>& samples) {
  // White noise has 1 (F of 19 and some 360 degrees of freedom: above 3 once in 10^4), that of a
  // sensor with a filter up to 3, a tone less. Drives of two simulators that pass the other test
  // have at least 5.6, most 40 to 200.
  constexpr double kAxisMax = 3.0;
  const std::vector<ImuSample> blocks = block_means(samples);
  const imu::ImuStatistics means = imu::statistics(blocks);
  const double in_block = static_cast<double>(samples.size()) / static_cast<double>(blocks.size());
  Row6 between;
  between << means.gyro_sd_radps, means.accel_sd_mps2;
  const Row6 F = in_block * between.cwiseAbs2().cwiseQuotient(variance_within(samples));
  return (F.array() < kAxisMax).all() && is_only_noise(blocks, 2);
}

bool has_travelled(const Vec3& displacement_m, const Mat3& covariance_m2, double limit_m) {
  const Mat3 allowed_m2 = kSigmas * kSigmas * covariance_m2 + limit_m * limit_m * Mat3::Identity();
  // Written so that NaN counts as travelled.
  return !(displacement_m.dot(allowed_m2.ldlt().solve(displacement_m)) <= 1.0);
}

bool has_turned(double turn_rad, double variance_rad2) {
  constexpr double kLimit_rad = 0.01;
  // Written so that NaN counts as turned.
  return !(turn_rad * turn_rad <= kSigmas * kSigmas * variance_rad2 + kLimit_rad * kLimit_rad);
}

}  // namespace rali::odometry
