#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/fleet/rounds/round_machine.hpp"

namespace rali::drive {

/// Writes rounds.csv and frontiers.csv (product.md 5) into a folder that exists. Errors: kMachine.
/// @param names of the vehicles, by their number
[[nodiscard]] Status write_rounds_table(const std::string& folder,
                                        const std::vector<std::string>& names,
                                        const std::vector<fleet::RoundRow>& rounds,
                                        const std::vector<fleet::FrontierRow>& frontiers);

}  // namespace rali::drive
