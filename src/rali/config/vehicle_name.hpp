#pragma once

#include <string>
#include <string_view>

namespace rali::config {

/// Names of vehicles become names of files, topics, columns and keys: letters, digits, _ and - of
/// ASCII and all of UTF-8 beyond it but what is not seen (controls, marks of direction, separators)
/// or not valid; at most 32 characters; no - at the start.
[[nodiscard]] bool is_vehicle_name(std::string_view name);

/// The name nearest to a text: what no name may hold becomes _, one for each character. "v1" where
/// nothing is left.
[[nodiscard]] std::string vehicle_name_from(std::string_view text);

}  // namespace rali::config
