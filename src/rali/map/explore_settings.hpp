#pragma once

#include "rali/base/settings.hpp"

namespace rali::map {

/// The 2-D grid in which frontiers are searched (algorithms_fleet 9.5). Coarser than the one for
/// display (GridSettings), and updated whenever poses have changed.
struct ExploreSettings {
  double cell_m = 0.2;
  double hit = 0.85, pass = -0.4;  ///< log-odds of one keyframe
  double occupied = 0.8, free = -0.4;
  double log_odds_min = -2.0, log_odds_max = 3.5;
  double band_low_m = 0.2;        ///< above the local ground
  double vehicle_height_m = 1.0;  ///< the band ends 0.2 m above it
  double vehicle_radius_m = 0.4;
  double range_m = 20.0;             ///< rays clear and mark cells up to here
  double ground_below_body_m = 0.0;  ///< height of the body over ground; 0 = from the data
  double slope_max_deg = 20.0;       ///< steeper is an obstacle
  double step_m = 0.15;              ///< higher steps are obstacles
  double drop_m = 0.3;               ///< deeper drops are obstacles, ...
  double drop_range_m = 5.0;         ///< ... if seen from nearer than this
  double move_m = 0.05;              ///< keyframes that moved less are not inserted again
  double cells_max = 2e7;            ///< larger grids are refused

  template <class V>
  void visit(V& v) {
    v("cell_m", cell_m, 0.05, 2.0, "side of a cell [m]");
    v("hit", hit, 0.01, 10.0, "log-odds of a keyframe that sees an obstacle");
    v("pass", pass, -10.0, -0.01, "log-odds of a keyframe whose rays pass");
    v("occupied", occupied, 0.0, 10.0, "an obstacle has more log-odds");
    v("free", free, -10.0, 0.0, "free space has fewer log-odds");
    v("log_odds_min", log_odds_min, -100.0, 0.0, "least log-odds of a cell");
    v("log_odds_max", log_odds_max, 0.0, 100.0, "most log-odds of a cell");
    v("band_low_m", band_low_m, 0.05, 2.0, "obstacles rise this far above the ground [m]");
    v("vehicle_height_m", vehicle_height_m, 0.1, 10.0, "height of the vehicle [m]");
    v("vehicle_radius_m", vehicle_radius_m, 0.05, 5.0, "half the width that a vehicle needs [m]");
    v("range_m", range_m, 1.0, 60.0, "rays count up to here [m]");
    v("ground_below_body_m", ground_below_body_m, 0.0, 10.0, "height of body over ground; 0: data");
    v("slope_max_deg", slope_max_deg, 1.0, 60.0, "steeper ground is an obstacle [deg]");
    v("step_m", step_m, 0.02, 2.0, "higher steps are obstacles [m]");
    v("drop_m", drop_m, 0.05, 10.0, "deeper drops are obstacles [m]");
    v("drop_range_m", drop_range_m, 0.5, 60.0, "drops are accepted up to this range [m]");
    v("move_m", move_m, 0.0, 1.0, "keyframes with a smaller correction stay in the grid [m]");
    v("cells_max", cells_max, 1e4, 4e8, "grids with more cells are refused");
  }
};

}  // namespace rali::map
