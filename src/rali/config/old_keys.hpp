#pragma once

#include <string>
#include <vector>

#include "rali/config/yaml_tree.hpp"

namespace rali::config {

/// Renames the keys of version 0.1 below `settings:` of a fleet.yaml, and takes away those that
/// have no meaning any more. Each gets one sentence in `notices`, with file and line and the new
/// name. Where the new name stands there as well, it wins.
[[nodiscard]] Node with_current_keys(Node root, std::vector<std::string>& notices);

/// The same for a KEY=VALUE of the command line, where `settings.` may be left out.
[[nodiscard]] Node assignment_with_current_keys(Node root, std::vector<std::string>& notices);

}  // namespace rali::config
