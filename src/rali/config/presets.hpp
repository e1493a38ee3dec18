#pragma once

#include <string>
#include <string_view>

namespace rali::config {

[[nodiscard]] bool is_preset(const std::string& name);

/// "robust, paper".
[[nodiscard]] std::string preset_names_text();

/// What the preset changes of `settings:`, as YAML over the defaults; empty for an unknown name.
[[nodiscard]] std::string_view preset_yaml(const std::string& name);

/// What the carrier (odometry.robust.carrier) changes of `settings:`; empty for that of the
/// defaults.
[[nodiscard]] std::string_view carrier_yaml(const std::string& name);

}  // namespace rali::config
