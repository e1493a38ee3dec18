#pragma once

#include <limits>

namespace rali::monitor {

/// Limits beyond which two estimates contradict each other. They are a little below those of a
/// failed run (0.3 m, 4 sigma, 2 s; docs/results.md), because the reference has errors, too.
struct MonitorSettings {
  double off_min_m = 0.2;   ///< two poses nearer to each other agree
  double sigmas_min = 3.0;  ///< so do poses nearer in sigmas of the checked one
  double span_min_s = 1.0;  ///< shorter contradictions are left out
  /// Longer ones are given in parts, each with its own figures: they show where the error grows.
  double part_max_s = std::numeric_limits<double>::infinity();
  /// Maximum fraction of walls in view that a keyframe's rays may pass. In correct maps of the
  /// campaign the largest fraction of a run is 0.001 to 0.02, in wrong ones 0.08 to 0.18.
  double through_max_ratio = 0.05;
  int looks_min = 1500;  ///< with fewer places on walls in view, a keyframe is not checked
  int made_min = 300;    ///< likewise for places that it saw first
  /// The same for walls that another vehicle saw first: 0.024 at most in correct maps, 0.43 to 0.99
  /// with wrong start poses or an anchor that was moved.
  double through_others_max_ratio = 0.2;
  int others_looks_min = 100;
};

}  // namespace rali::monitor
