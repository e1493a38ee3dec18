#pragma once

#include <string>
#include <vector>

#include "rali/config/yaml_tree.hpp"

namespace rali::scenario {

/// Renames the keys of scene.yaml that were called otherwise in version 0.1, also those of one
/// assignment of the command line. Each gets one sentence in `notices`, with file and line and the
/// new name. Where the new name stands there as well, it wins.
[[nodiscard]] config::Node with_current_scene_keys(config::Node root,
                                                   std::vector<std::string>& notices);

}  // namespace rali::scenario
