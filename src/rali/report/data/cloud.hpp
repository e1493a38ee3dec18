#pragma once

#include <cstddef>

#include <nlohmann/json.hpp>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Interval that contains nearly all values; `known` if there were any.
struct Span {
  double low = 0.0, high = 1.0;
  bool known = false;
};

/// Interval of the bulk of a cloud: a few distant points must not shrink the drawn map.
/// @param axis 0 x, 1 y, 2 z. @return 0.1 % to 99.9 % of the points' values.
[[nodiscard]] Span span_of_points(const MapPoints& map, std::size_t axis);

/// Expected error of the points, 2nd to 98th percentile.
[[nodiscard]] Span span_of_sigma(const MapPoints& map);

/// The cloud for the drawings, thinned to `points_max` by position alone: int16 x y z in steps
/// around a centre, and per point its level of height and of expected error, and its vehicle. Null
/// without points.
[[nodiscard]] nlohmann::ordered_json cloud_json(const MapPoints& map, std::size_t points_max);

}  // namespace rali::report
