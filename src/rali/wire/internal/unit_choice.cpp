#include "rali/wire/internal/unit_choice.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace rali::wire::internal {
namespace {

/// With this fraction of points in range a map can be made.
constexpr double kWithinMin = 0.1;
constexpr std::size_t kPointsMin = 100;
/// The nearest points of a scan (ground, walls, the vehicle) are about 1 m away and half of all
/// within about 5 m, each to a factor of 3 or so: their geometric mean, 2.2 m, is 220 in
/// centimetres and 2200 in millimetres. The limit is their geometric mean:
constexpr double kMillimetresFrom = 700.0;
constexpr double kCentimetres = 100.0, kMillimetres = 1000.0;

/// Distances of all points that are finite and not the origin, in the unit of the file.
std::vector<double> distances(const FirstClouds& first) {
  std::vector<double> found;
  for (const FirstClouds::Cloud& cloud : first.clouds) {
    for (std::size_t i = 0; i < cloud.x_m.size(); ++i) {
      const double d = std::hypot(cloud.x_m[i], cloud.y_m[i], cloud.z_m[i]);
      if (std::isfinite(d) && d > 1e-3) found.push_back(d);
    }
  }
  return found;
}

double quantile(std::vector<double>& values, double fraction) {
  const auto k = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

}  // namespace

Status check_unit(const FirstClouds& first, const CloudFormatOptions& options) {
  std::vector<double> d = distances(first);
  if (d.size() < kPointsMin) return {};
  const auto within = static_cast<double>(std::count_if(d.begin(), d.end(), [&](double v) {
    return v >= options.range_m[0] && v <= options.range_m[1];
  }));
  if (within >= kWithinMin * static_cast<double>(d.size())) return {};
  const double middle = median(d);
  if (middle <= options.range_m[1]) return {};
  // Values beyond the limit even in centimetres must be in a smaller unit.
  const bool millimetres = std::sqrt(quantile(d, 0.01) * middle) > kMillimetresFrom ||
                           quantile(d, 0.99) > kCentimetres * options.range_m[1];
  if (middle / (millimetres ? kMillimetres : kCentimetres) > options.range_m[1]) return {};
  return fail(ErrorCode::kInput, {},
              fmt::format("half of the points are more than {:.0f} away, beyond the range limit of "
                          "{:g} m: by these values the unit is {}, not metres",
                          middle, options.range_m[1], millimetres ? "millimetres" : "centimetres"),
              "Convert the clouds to metres; if they are in metres, set lidar.range_m.");
}

}  // namespace rali::wire::internal
