#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rali/config/yaml_tree.hpp"

namespace rali::config {

struct RenamedKey {
  std::string_view old_key, key;  ///< full keys, of a group or a value
};

struct RemovedKey {
  std::string_view key, reason;  ///< a group includes all its keys
};

/// Names of the keys of a file in an earlier version. A key of a renamed group that is not listed
/// keeps its name within the group. Maps in a list have the list's key: escorts.start_s.
struct KeyChanges {
  std::span<const RenamedKey> renamed;
  std::span<const RemovedKey> removed;
  std::string_view prefix;  ///< prefix of the keys in notices: "settings."
};

/// Renames the values in `root` to the current names and removes those without meaning. Each gets
/// one sentence in `notices`, with file and line and the new name. If the new name is present too,
/// it takes precedence.
void apply_key_changes(const KeyChanges& changes, Node& root, std::vector<std::string>& notices);

}  // namespace rali::config
