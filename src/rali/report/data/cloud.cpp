#include "rali/report/data/cloud.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "rali/report/internal/colours.hpp"
#include "rali/report/internal/html.hpp"
#include "rali/report/thinned_map.hpp"

namespace rali::report {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLevels = 64, kSampleMax = 200'000;
constexpr double kSteps = 32000.0;  ///< for half the widest side, in an int16

/// Quantiles `tail` and 1 - `tail` of a sample of the finite values.
template <class Keep>
Span span_between(const std::vector<float>& values, double tail, Keep&& keep) {
  std::vector<float> sample;
  const std::size_t stride = values.size() / kSampleMax + 1;
  for (std::size_t i = 0; i < values.size(); i += stride) {
    if (std::isfinite(values[i]) && keep(values[i])) sample.push_back(values[i]);
  }
  if (sample.empty()) return {};
  std::sort(sample.begin(), sample.end());
  const auto cut = static_cast<std::size_t>(tail * static_cast<double>(sample.size()));
  return {static_cast<double>(sample[cut]), static_cast<double>(sample[sample.size() - 1 - cut]),
          true};
}

using Box = std::array<Span, 3>;

/// The selection of drawn points depends on their index alone.
std::vector<std::size_t> kept_points(const MapPoints& map, const Box& box, std::size_t max) {
  const double part =
      static_cast<double>(max) / static_cast<double>(std::max<std::size_t>(map.size(), 1));
  const auto limit = static_cast<std::uint64_t>(std::min(part, 0.999999) * 18446744073709549568.0);
  const auto inside = [](const Span& s, float v) {
    return static_cast<double>(v) >= s.low && static_cast<double>(v) <= s.high;
  };
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (part < 1.0 && mixed(i) > limit) continue;
    if (inside(box[0], map.x_m[i]) && inside(box[1], map.y_m[i]) && inside(box[2], map.z_m[i])) {
      kept.push_back(i);
    }
  }
  return kept;
}

std::uint8_t level(double value, const Span& span) {
  const double place = (value - span.low) / std::max(span.high - span.low, 1e-9);
  if (!std::isfinite(place)) return 0;
  return static_cast<std::uint8_t>(std::clamp(place, 0.0, 1.0) * (kLevels - 1));
}

Json palette() {
  Json list = Json::array();
  for (std::size_t i = 0; i < kLevels; ++i) {
    list.push_back(scale_colour(static_cast<double>(i) / (kLevels - 1), false));
  }
  return list;
}

}  // namespace

Span span_of_points(const MapPoints& map, std::size_t axis) {
  const std::array<const std::vector<float>*, 3> axes = {&map.x_m, &map.y_m, &map.z_m};
  return span_between(*axes.at(axis), 0.001, [](float) { return true; });
}

Span span_of_sigma(const MapPoints& map) {
  return span_between(map.sigma_m, 0.02, [](float s) { return s > 0.0F; });
}

Json cloud_json(const MapPoints& map, std::size_t points_max) {
  if (map.size() == 0) return nullptr;
  Box box;
  std::array<double, 3> centre{};
  double half_m = 0.5;
  for (std::size_t a = 0; a < 3; ++a) {
    box[a] = span_of_points(map, a);
    box[a].low -= 0.05, box[a].high += 0.05;
    centre[a] = 0.5 * (box[a].low + box[a].high);
    half_m = std::max(half_m, 0.5 * (box[a].high - box[a].low));
  }
  const Span error = span_of_sigma(map);
  std::vector<std::int16_t> points;
  std::vector<std::uint8_t> height, sigma, vehicle;
  const std::vector<std::size_t> kept = kept_points(map, box, points_max);
  for (const std::size_t i : kept) {
    const std::array<float, 3> p = {map.x_m[i], map.y_m[i], map.z_m[i]};
    for (std::size_t a = 0; a < 3; ++a) {
      const double steps = (static_cast<double>(p[a]) - centre[a]) / half_m * kSteps;
      points.push_back(static_cast<std::int16_t>(std::lround(std::clamp(steps, -kSteps, kSteps))));
    }
    height.push_back(level(static_cast<double>(p[2]), box[2]));
    // The palette's dark end marks the large error.
    sigma.push_back(
        static_cast<std::uint8_t>(kLevels - 1 - level(static_cast<double>(map.sigma_m[i]), error)));
    vehicle.push_back(map.vehicle[i]);
  }
  return {{"count", kept.size()},
          {"centre_m", centre},
          {"step_m", half_m / kSteps},
          {"low_m", {box[0].low, box[1].low, box[2].low}},
          {"high_m", {box[0].high, box[1].high, box[2].high}},
          {"palette", palette()},
          {"points", packed(points)},
          {"height", packed(height)},
          {"sigma", packed(sigma)},
          {"vehicle", packed(vehicle)}};
}

}  // namespace rali::report
