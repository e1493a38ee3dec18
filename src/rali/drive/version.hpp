#pragma once

#include <string_view>

namespace rali::drive {

/// Written into every output that says which program made it.
inline constexpr std::string_view kVersion = "0.1.0";

}  // namespace rali::drive
