#pragma once

#include <string>
#include <vector>

#include "study.hpp"

namespace rali::recognition {

/// Candidates, recognition without and with a guess, cost: one row per scene each.
[[nodiscard]] std::string tables(const std::vector<Figures>& figures);

}  // namespace rali::recognition
