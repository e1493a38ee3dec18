#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/closed_loop/fleet_software.hpp"

namespace rali::drive {

/// Writes rounds.csv and frontiers.csv (product.md 5) into a folder that exists. Errors: kMachine.
[[nodiscard]] Status write_mission_files(const std::string& folder, const MissionLog& log,
                                         const std::vector<std::string>& names);

}  // namespace rali::drive
