#pragma once

#include <string>

#include "arguments.hpp"
#include "run.hpp"

namespace rali::accuracy {

/// The command that reproduces these runs, without options that do not change figures.
[[nodiscard]] std::string command_of(const std::vector<std::string>& words);

/// One row per scene and preset, most requested columns only: median / worst over seeds.
[[nodiscard]] std::string short_table(const std::vector<Scores>& runs);

}  // namespace rali::accuracy
