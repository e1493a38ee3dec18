#pragma once

#include <string>
#include <vector>

#include "run.hpp"

namespace rali::tunnel {

/// Rows of one table.
struct Suite {
  std::string name;
  std::vector<Row> rows;
};

/// acceptance: the tunnel with all priors and ranges. harm: worlds that need no ranges, with and
/// without them. ablation: the tunnel with parts left out. mesh: the map against the world.
/// Errors (kUsage): no such suite.
[[nodiscard]] Result<Suite> suite_of(const std::string& name);

}  // namespace rali::tunnel
