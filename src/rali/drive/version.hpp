#pragma once

#include <string_view>

namespace rali::drive {

/// Written into every output that states which program made it.
[[nodiscard]] std::string_view version();

}  // namespace rali::drive
