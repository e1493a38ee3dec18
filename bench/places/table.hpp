#pragma once

#include <string>
#include <vector>

#include "stages.hpp"
#include "study.hpp"

namespace rali::recognition {

/// Candidates, recognition without and with a guess, cost: one row per scene each.
[[nodiscard]] std::string tables(const std::vector<Figures>& figures);

/// One row per scene.
[[nodiscard]] std::string table_of(const std::vector<Stages>& stages);

}  // namespace rali::recognition
