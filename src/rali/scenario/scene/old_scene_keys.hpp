#pragma once

#include <string>
#include <vector>

#include "rali/config/yaml_tree.hpp"

namespace rali::scenario {

/// Renames keys of scene.yaml that had another name in version 0.1, also in one assignment of the
/// command line. Each gets one sentence in `notices`, with file, line and new name. If the new name
/// is present as well, it has priority.
[[nodiscard]] config::Node with_current_scene_keys(config::Node root,
                                                   std::vector<std::string>& notices);

}  // namespace rali::scenario
