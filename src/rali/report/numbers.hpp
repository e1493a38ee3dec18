#pragma once

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::report {

/// An unknown value.
inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

using Number = std::optional<double>;
using NamedNumbers = std::vector<std::pair<std::string, double>>;

struct PathPoint {
  double t_s = 0.0;
  geometry::Vec3 p_m = geometry::Vec3::Zero();
};

}  // namespace rali::report
