#pragma once

#include <string>
#include <string_view>

namespace rali::config {

[[nodiscard]] bool is_preset(const std::string& name);

/// "robust, paper".
[[nodiscard]] std::string preset_names_text();

/// The changes of the preset to `settings:`, as YAML over the defaults; empty for an unknown name.
[[nodiscard]] std::string_view preset_yaml(const std::string& name);

/// The changes of the carrier (odometry.robust.carrier) to `settings:`; empty for the default
/// carrier.
[[nodiscard]] std::string_view carrier_yaml(const std::string& name);

}  // namespace rali::config
