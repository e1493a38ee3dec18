#pragma once

#include <string_view>

#include "rali/fleet/messages/messages.hpp"

namespace rali::host {

/// A vehicle's activity, in one word of the live page.
[[nodiscard]] std::string_view mode_word(fleet::Mode mode);

/// Its role: anchor, tag, candidate, sealed or orphan.
[[nodiscard]] std::string_view role_word(fleet::Mode mode);

/// What a vehicle in this mode waits for: the end of a sentence that starts with its name.
[[nodiscard]] std::string_view waiting_words(fleet::Mode mode, bool has_goal);

}  // namespace rali::host
