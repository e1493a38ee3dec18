#pragma once

#include <string>

namespace rali::view_demo {

/// `/rali/state` at a time, as specified in src/rali/view/README.md.
[[nodiscard]] std::string state_at(double t_s);

/// `/rali/paths` at a time.
[[nodiscard]] std::string paths_at(double t_s);

/// Displacement of the points of v3 before the table corrects them [m].
[[nodiscard]] double gallery_error_m(double t_s);

}  // namespace rali::view_demo
