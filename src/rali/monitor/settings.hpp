#pragma once

namespace rali::monitor {

/// When two statements about one thing contradict each other. The limits lie a little below what
/// counts as a failure of a run (0.3 m, 4 sigma, 2 s; docs/results.md), because the reference
/// errs, too.
struct MonitorSettings {
  double off_min_m = 0.2;   ///< two poses nearer to each other agree
  double sigmas_min = 3.0;  ///< so do poses nearer in sigmas of the one that is judged
  double span_min_s = 1.0;  ///< shorter contradictions are left out
  /// Walls of the map that the rays of a keyframe may go through. In right maps of the campaign the
  /// largest fraction of a run is 0.001 to 0.02, in wrong ones 0.08 to 0.18.
  double through_max_ratio = 0.05;
  int looks_min = 1500;  ///< fewer places on walls in view: a keyframe is not judged
  int made_min = 300;    ///< nor are fewer places that it was the first to see
  /// The same of walls that another vehicle made: 0.024 at most in right maps, 0.43 to 0.99 in
  /// those of wrong start poses or of an anchor that was moved.
  double through_others_max_ratio = 0.2;
  int others_looks_min = 100;
};

}  // namespace rali::monitor
