#pragma once

#include <span>
#include <string>
#include <string_view>

namespace rali::config {

/// Settings that address one symptom, in the words of a user of the map.
struct SymptomGroup {
  std::string_view symptom;
  std::string_view advice;  ///< what to try first
  std::span<const std::string_view> keys;
};

/// All public settings by symptom; `v1` stands for each vehicle. Their names are stable; all other
/// settings may change with any release. At most kPublicSettingsMax.
[[nodiscard]] std::span<const SymptomGroup> public_settings();

inline constexpr std::size_t kPublicSettingsMax = 60;

/// Whether a full key is public; vehicles.NAME counts as vehicles.v1.
[[nodiscard]] bool is_public_setting(std::string_view key);

}  // namespace rali::config
