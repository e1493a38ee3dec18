#pragma once

#include "rali/base/settings.hpp"

namespace rali::odometry {

/// Settings of preset `paper`: every ambiguity of the text (algorithms.md table 0.2).
struct PaperSettings {
  template <class V>
  void visit(V& /*v*/) {}
};

}  // namespace rali::odometry
