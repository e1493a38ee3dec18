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
  std::string_view key, reason;  ///< a group goes with all that it has
};

/// How the keys of a file were called in an earlier version. A key of a renamed group that is not
/// listed keeps its name within it. Maps in a list have the list's key: escorts.begin_s.
struct KeyChanges {
  std::span<const RenamedKey> renamed;
  std::span<const RemovedKey> removed;
  std::string_view prefix;  ///< before the keys in notices: "settings."
};

/// Gives the values in `root` the names of today, and takes away those that have no meaning any
/// more. Each gets one sentence in `notices`, with file and line and the new name. Where the new
/// name stands there as well, it wins.
void apply_key_changes(const KeyChanges& changes, Node& root, std::vector<std::string>& notices);

}  // namespace rali::config
