#pragma once

#include <string>

namespace rali {

/// Version of the library, as `rali --version` prints it: "0.2.0", between releases with the number
/// of commits since and the commit.
[[nodiscard]] std::string version();

}  // namespace rali
