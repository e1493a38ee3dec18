#include "rali/map/ground_height.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace rali::map {
namespace {

constexpr double kReach_m = 5.0;
constexpr double kDeepest_m = 3.0;  ///< below the LiDAR: larger vehicles need the setting
constexpr double kBin_m = 0.05;
constexpr std::size_t kBins = 60;
constexpr std::size_t kPointsMin = 30;

}  // namespace

std::optional<double> ground_below_body(const KeyframeView& keyframe) {
  const geometry::Vec3 sensor = keyframe.T_map_body * keyframe.T_body_lidar.p;
  std::array<std::size_t, kBins> count{};
  std::array<double, kBins> sum_m{};
  std::size_t total = 0;
  for (std::size_t i = 0; i < keyframe.size(); ++i) {
    const geometry::Vec3 d = keyframe.T_map_body * keyframe.point_body(i) - sensor;
    const double below_m = -d.z();
    if (!(d.head<2>().norm() < kReach_m) || !(below_m > kBin_m) || below_m >= kDeepest_m) continue;
    const auto bin = static_cast<std::size_t>(below_m / kBin_m);
    ++count[bin];
    sum_m[bin] += below_m;
    ++total;
  }
  // The ground is the lowest pair of bins with enough points; single deeper points are mirrored.
  const std::size_t needed = std::max(kPointsMin, total / 10);
  for (std::size_t bin = kBins - 1; bin > 0; --bin) {
    const std::size_t n = count[bin] + count[bin - 1];
    if (n < needed) continue;
    const double below_lidar_m = (sum_m[bin] + sum_m[bin - 1]) / static_cast<double>(n);
    return below_lidar_m + keyframe.T_map_body.p.z() - sensor.z();
  }
  return std::nullopt;
}

}  // namespace rali::map
