#pragma once

#include "rali/base/settings.hpp"

namespace rali::odometry {

/// Settings of preset `robust`.
struct RobustSettings {
  template <class V>
  void visit(V& /*v*/) {}
};

}  // namespace rali::odometry
