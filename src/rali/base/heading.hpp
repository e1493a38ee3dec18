#pragma once

#include <numbers>

namespace rali {

/// Whether a sigma [rad] says anything about a heading: over all directions it is 104 degrees, and
/// linearised estimates of an unobserved heading state more turns than a circle has.
[[nodiscard]] inline bool heading_is_known(double sigma_rad) {
  return sigma_rad < std::numbers::pi / 3.0;
}

}  // namespace rali
