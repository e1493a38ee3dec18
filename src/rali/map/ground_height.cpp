#include "rali/map/ground_height.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace rali::map {
namespace {

using geometry::Vec2;
using geometry::Vec3;

/// The ground next to the vehicle, or where the steepest ring of a LiDAR 3 m up reaches it.
constexpr std::array kReach_m = {5.0, 12.0};
constexpr double kDeepest_m = 3.0;  ///< below the LiDAR: larger vehicles need the setting
constexpr double kBin_m = 0.05;
constexpr std::size_t kBins = 60;
constexpr std::size_t kPointsMin = 30;
/// A body tilted more has axes that are not the vehicle's, or lies on its side.
constexpr double kUpright = 0.77;  // cosine of 40 degrees

/// A plane square to `up`.
struct Layer {
  double below_body_m = 0.0;  ///< along up
  std::size_t points = 0;
};

/// The lowest pair of bins with enough points; single deeper points are mirrored.
std::optional<Layer> lowest_layer(const KeyframeView& keyframe, const Vec3& up, double reach_m) {
  const Vec3 sensor = keyframe.T_map_body * keyframe.T_body_lidar.p;
  std::array<std::size_t, kBins> count{};
  std::array<double, kBins> sum_m{};
  std::size_t total = 0;
  for (std::size_t i = 0; i < keyframe.size(); ++i) {
    const Vec3 d = keyframe.T_map_body * keyframe.point_body(i) - sensor;
    const double below_m = -up.dot(d);
    const double beside_m = (d + below_m * up).norm();
    if (!(beside_m < reach_m) || !(below_m > kBin_m) || below_m >= kDeepest_m) continue;
    const auto bin = static_cast<std::size_t>(below_m / kBin_m);
    ++count[bin];
    sum_m[bin] += below_m;
    ++total;
  }
  const std::size_t needed = std::max(kPointsMin, total / 10);
  for (std::size_t bin = kBins - 1; bin > 0; --bin) {
    const std::size_t n = count[bin] + count[bin - 1];
    if (n < needed) continue;
    const double below_lidar_m = (sum_m[bin] + sum_m[bin - 1]) / static_cast<double>(n);
    return Layer{below_lidar_m + up.dot(keyframe.T_map_body.p - sensor), n};
  }
  return std::nullopt;
}

std::optional<Ground> ground_within(const KeyframeView& keyframe, double reach_m) {
  const std::optional<Layer> level = lowest_layer(keyframe, Vec3::UnitZ(), reach_m);
  const Vec3 up = keyframe.T_map_body.R.col(2);
  const std::optional<Layer> inclined =
      up.z() > kUpright ? lowest_layer(keyframe, up, reach_m) : level;
  if (inclined && inclined->points > (level ? level->points : 0)) {
    return Ground{inclined->below_body_m / up.z(), -up.head<2>() / up.z()};
  }
  if (level) return Ground{level->below_body_m, Vec2::Zero()};
  return std::nullopt;
}

}  // namespace

std::optional<Ground> ground_below(const KeyframeView& keyframe) {
  for (const double reach_m : kReach_m) {
    if (const auto found = ground_within(keyframe, reach_m)) return found;
  }
  return std::nullopt;
}

std::optional<Ground> VehicleGround::below(VehicleId vehicle, const KeyframeView& keyframe) {
  std::optional<Ground> found = ground_below(keyframe);
  std::vector<double>& distances_m = distances_m_[vehicle];
  // Along the ground's normal, so that an incline changes nothing.
  const double steepness = found ? std::sqrt(1.0 + found->rise_map.squaredNorm()) : 1.0;
  if (found) {
    const double distance_m = found->below_body_m / steepness;
    distances_m.insert(std::upper_bound(distances_m.begin(), distances_m.end(), distance_m),
                       distance_m);
  }
  if (!(given_m_ > 0.0) && distances_m.empty()) return std::nullopt;
  const double distance_m = given_m_ > 0.0 ? given_m_ : distances_m[distances_m.size() / 2];
  if (!found) found = Ground{};
  found->below_body_m = distance_m * steepness;
  return found;
}

}  // namespace rali::map
