#pragma once

#include <array>

#include "rali/base/settings.hpp"

namespace rali::map {

/// Removal of objects that moved while they were seen (people, other vehicles).
struct DynamicSettings {
  bool remove = true;
  double voxel_m = 0.1;             ///< side of the cells that are classified as a whole
  double range_m = 25.0;            ///< farther rays are no evidence
  double margin_m = 0.3;            ///< a ray must end this much behind a place to have passed it
  double thin_m = 0.06;             ///< rays spread wider than this may miss a pole: no evidence
  double passes_min = 2.0;          ///< keyframes whose rays passed the place
  double separation_s = 1.0;        ///< between the first and last of them
  double pass_fraction = 0.4;       ///< passes / (passes + hits) above which the place was empty
  double pose_sigma_max_m = 0.5;    ///< of a pose relative to that which saw the place; else no
                                    ///< evidence
  double look_fraction_max = 0.08;  ///< planes a keyframe's rays pass; more: its pose is wrong
  double plane_fraction_max =
      0.05;                    ///< more planes gone than this: the poses are wrong, remove none
  double peer_radius_m = 0.8;  ///< around another vehicle's body, level
  double peer_height_m = 0.8;  ///< above and below it

  template <class V>
  void visit(V& v) {
    v("remove", remove, "take moving objects out of the map");
    v("voxel_m", voxel_m, 0.02, 1.0, "side of the cells that are removed as a whole [m]");
    v("range_m", range_m, 2.0, 200.0, "rays beyond this prove nothing [m]");
    v("margin_m", margin_m, 0.05, 5.0, "a passing ray ends this much behind [m]");
    v("thin_m", thin_m, 0.005, 1.0, "rays spread wider than this prove nothing [m]");
    v("passes_min", passes_min, 1.0, 1000.0, "keyframes whose rays must pass through a cell");
    v("separation_s", separation_s, 0.0, 1000.0, "time between first and last of them [s]");
    v("pass_fraction", pass_fraction, 0.0, 1.0, "passes / (passes + hits) of an empty place");
    v("pose_sigma_max_m", pose_sigma_max_m, 0.01, 100.0,
      "keyframes with a larger relative sigma prove nothing");
    v("through_fraction_max", look_fraction_max, 0.0, 1.0,
      "fraction of planes that the rays of a keyframe may pass through");
    v("plane_fraction_max", plane_fraction_max, 0.0, 1.0,
      "more planes gone than this: remove none");
    v("peer_radius_m", peer_radius_m, 0.0, 20.0,
      "radius around other vehicles in which points are removed; 0: none [m]");
    v("peer_height_m", peer_height_m, 0.0, 20.0, "height of that above and below their bodies [m]");
  }
};

/// The 2-D occupancy grid.
struct GridSettings {
  bool make = true;
  double cell_m = 0.05;
  std::array<double, 2> z_m = {0.15, 1.5};  ///< band above the ground at the vehicle
  double range_m = 20.0;                    ///< rays clear and mark cells up to here
  double ground_below_body_m = 0.0;         ///< height of the body over ground; 0 = from the data
  double hits_min = 2.0;                    ///< keyframes that must hit a cell that was passed too
  double hit_fraction = 0.2;                ///< hits / (hits + passes) of an occupied cell
  double cells_max = 4e8;                   ///< larger grids are refused

  template <class V>
  void visit(V& v) {
    v("make", make, "write the 2-D grid");
    v("cell_m", cell_m, 0.01, 1.0, "side of a cell [m]");
    v("z_m", z_m, -10.0, 50.0, "band above ground that is an obstacle [m]");
    v("range_m", range_m, 1.0, 100.0, "rays count up to here [m]");
    v("ground_below_body_m", ground_below_body_m, 0.0, 10.0, "height of body over ground; 0: data");
    v("hits_min", hits_min, 1.0, 1000.0, "keyframes that hit an occupied cell");
    v("hit_fraction", hit_fraction, 0.0, 1.0, "hits / (hits + passes) of an occupied cell");
    v("cells_max", cells_max, 1e4, 4e9, "grids with more cells are refused");
  }
};

/// Settings of module `map`.
struct MapSettings {
  double voxel_m = 0.05;             ///< 0 keeps every point
  double max_memory_mb = 0.0;        ///< 0 = no limit
  double range_sigma_m = 0.02;       ///< noise of one range, independent from point to point
  double bearing_sigma_rad = 0.001;  ///< noise of one ray's direction, independent likewise
  double systematic_m = 0.01;        ///< sensor error common to all points
  DynamicSettings dynamic;
  GridSettings grid;

  template <class V>
  void visit(V& v) {
    v("voxel_m", voxel_m, 0.0, 10.0, "one point per cube of this side; 0 keeps all [m]");
    v("max_memory_mb", max_memory_mb, 0.0, 1e6, "largest memory of the map; 0: no limit [MB]");
    v("range_sigma_m", range_sigma_m, 0.0, 1.0, "noise of one range [m]");
    v("bearing_sigma_rad", bearing_sigma_rad, 0.0, 0.1, "noise of one ray's direction [rad]");
    v("systematic_m", systematic_m, 0.0, 1.0, "error that all points of a sensor share [m]");
    v.group("dynamic", dynamic, "removal of moving objects");
    v.group("grid", grid, "2-D occupancy grid");
  }
};

}  // namespace rali::map
