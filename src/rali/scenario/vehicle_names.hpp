#pragma once

#include <string>
#include <vector>

namespace rali::scenario {

/// Names of simulated vehicles, by number: v1, v2, ...
[[nodiscard]] inline std::vector<std::string> vehicle_names(int vehicles) {
  std::vector<std::string> names;
  for (int v = 1; v <= vehicles; ++v) names.push_back('v' + std::to_string(v));
  return names;
}

}  // namespace rali::scenario
