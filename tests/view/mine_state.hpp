#pragma once

#include <string>

namespace rali::view_demo {

/// `/rali/state` at a time, as src/rali/view/README.md has it.
[[nodiscard]] std::string state_at(double t_s);

/// `/rali/paths` at a time.
[[nodiscard]] std::string paths_at(double t_s);

/// How far the points of v3 are off before the table moves them [m].
[[nodiscard]] double gallery_error_m(double t_s);

}  // namespace rali::view_demo
