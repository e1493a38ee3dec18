#pragma once

#include "rali/base/settings.hpp"

namespace rali::graph {

/// Settings of the local pose graph (algorithms 6). Which keyframes stay in the window is the
/// caller's policy; the numbers for it are here so that they are declared once.
struct LocalGraphSettings {
  int window_keyframes = 20;
  double window_blind_s = 30.0;  ///< while a direction is blind the window is at least this long
  int window_keyframes_max = 60;
  int iterations = 5;
  double huber_sd = 2.0;
  /// Not 1e-4: damping holds each keyframe of a long stiff stretch, and a shift of the whole
  /// stretch then takes five steps instead of three.
  double lambda_initial = 1e-6;
  double cost_change_min = 1e-4;
  double step_min_m = 1e-4;
  double range_memory_s = 60.0;

  template <class V>
  void visit(V& v) {
    v("window_keyframes", window_keyframes, 2, 1000, "keyframes that are solved together");
    v("window_blind_s", window_blind_s, 0.0, 600.0,
      "the window reaches back at least so far while a direction is blind");
    v("window_keyframes_max", window_keyframes_max, 2, 1000, "and has never more keyframes");
    v("iterations", iterations, 1, 100, "Levenberg-Marquardt steps at each keyframe, at most");
    v("huber_sd", huber_sd, 0.5, 1e6, "residuals of ranges beyond so many sigma count less");
    v("lambda_initial", lambda_initial, 1e-12, 1.0, "damping of the first step");
    v("cost_change_min", cost_change_min, 0.0, 0.1, "stop when the cost falls by less (relative)");
    v("step_min_m", step_min_m, 0.0, 0.1, "stop when nothing moves farther");
    v("range_memory_s", range_memory_s, 0.0, 3600.0,
      "how long before the oldest keyframe a range is still remembered as used");
  }
};

}  // namespace rali::graph
