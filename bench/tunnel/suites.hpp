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

/// acceptance: the tunnel, all that can be known and heard there. harm: places that need no ranges,
/// with and without. ablation: the tunnel with parts left out. mesh: the map against the world.
/// Errors (kUsage): no such suite.
[[nodiscard]] Result<Suite> suite_of(const std::string& name);

}  // namespace rali::tunnel
