#pragma once

#include <string>
#include <vector>

#include "rali/config/yaml_tree.hpp"

namespace rali::config {

/// Renames the keys of version 0.1 below `settings:` of a fleet.yaml and removes those without
/// meaning. Each gets one sentence in `notices`, with file and line and the new name. If the new
/// name is present too, it takes precedence.
[[nodiscard]] Node with_current_keys(Node root, std::vector<std::string>& notices);

/// The same for a KEY=VALUE of the command line, where `settings.` may be left out.
[[nodiscard]] Node assignment_with_current_keys(Node root, std::vector<std::string>& notices);

}  // namespace rali::config
