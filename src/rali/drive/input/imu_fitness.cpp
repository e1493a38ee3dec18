#include "rali/drive/input/imu_fitness.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

namespace rali::drive {
namespace {

/// Sensors start one after the other; a longer pause between them is not due to the start.
constexpr double kApart_s = 5.0;
constexpr double kSamplesPerScan = 2.0;
constexpr std::size_t kStepsMin = 2;  ///< two steps give a rate, one may be a gap

/// Median of the steps; empty with too few.
std::optional<double> period_s(std::span<const Time> times) {
  std::vector<Time> sorted(times.begin(), times.end());
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double step_s = seconds_between(sorted[i - 1], sorted[i]);
    if (step_s > 0.0) steps_s.push_back(step_s);
  }
  if (steps_s.size() < kStepsMin) return std::nullopt;
  const auto middle = steps_s.begin() + static_cast<std::ptrdiff_t>(steps_s.size() / 2);
  std::nth_element(steps_s.begin(), middle, steps_s.end());
  return *middle;
}

}  // namespace

std::optional<std::string> unfit_inertial(std::span<const Time> scans, std::span<const Time> imu) {
  if (scans.empty() || imu.empty()) return std::nullopt;
  const auto [scan_first, scan_last] = std::minmax_element(scans.begin(), scans.end());
  const auto [imu_first, imu_last] = std::minmax_element(imu.begin(), imu.end());
  const double after_s = seconds_between(*scan_last, *imu_first);
  if (after_s > kApart_s) {
    return fmt::format("inertial data lie wholly after the scans, by {:.1f} s", after_s);
  }
  const double before_s = seconds_between(*imu_last, *scan_first);
  if (before_s > kApart_s) {
    return fmt::format("inertial data lie wholly before the scans, by {:.1f} s", before_s);
  }
  const std::optional<double> imu_s = period_s(imu), scan_s = period_s(scans);
  if (!imu_s || !scan_s || kSamplesPerScan * *imu_s <= *scan_s) return std::nullopt;
  return fmt::format("inertial data come at {:.1f} Hz, too slow to be integrated", 1.0 / *imu_s);
}

}  // namespace rali::drive
