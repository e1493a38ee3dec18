#pragma once

#include <string>
#include <vector>

#include "rali/jobs/load_inputs.hpp"

namespace rali::jobs {

/// Whether an input is a fleet.yaml.
[[nodiscard]] bool is_yaml(const std::string& input);

/// load_inputs() where at least one input is a state folder.
[[nodiscard]] Result<MapInputs> load_states(const std::vector<std::string>& inputs,
                                            const config::Overrides& overrides);

}  // namespace rali::jobs
