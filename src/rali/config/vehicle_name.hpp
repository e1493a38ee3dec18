#pragma once

#include <string>
#include <string_view>

namespace rali::config {

/// Vehicle names become names of files, topics, columns and keys. Allowed: letters, digits, _ and -
/// of ASCII, and valid UTF-8 beyond ASCII except invisible characters (controls, direction marks,
/// separators). At most 32 characters; no - at the start.
[[nodiscard]] bool is_vehicle_name(std::string_view name);

/// A valid name derived from a text: each forbidden character becomes _. "v1" if nothing is left.
[[nodiscard]] std::string vehicle_name_from(std::string_view text);

}  // namespace rali::config
