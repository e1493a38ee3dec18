#pragma once

#include "rali/base/result.hpp"
#include "rali/base/rng.hpp"
#include "rali/sim/world.hpp"

namespace rali::sim {

/// Arched tunnel or round pipe. Its axis has one curvature and gradient, or segments with
/// curvatures and gradients drawn at random.
struct TunnelOptions {
  double length_m = 200.0;
  double width_m = 5.0;
  double wall_height_m = 1.2;    ///< of the vertical part; the arch is on top of it
  bool round = false;            ///< a pipe of this width: a circle is floor, walls and arch
  double curvature_per_m = 0.0;  ///< 1/radius, positive to the left
  double gradient = 0.0;         ///< rise per metre
  double segment_m = 0.0;        ///< mean length of segments; 0: one curvature and gradient for all
  double segment_curvature_per_m = 0.0;  ///< largest curvature of segments, either sign
  double segment_gradient = 0.0;         ///< largest gradient of segments, either sign
  double cabinet_every_m = 0.0;          ///< mean distance between cabinets at the walls; 0: none
  double roughness_m = 0.008;            ///< shotcrete
  double niche_every_m = 0.0;            ///< distance of niches on alternating sides; 0: none
  double reflectivity = 0.4;
  bool closed_ends = false;  ///< a wall across each end; false: open portals

  template <class V>
  void visit(V& v) {
    v("length_m", length_m, 10.0, 20000.0, "length along the axis");
    v("width_m", width_m, 1.5, 30.0, "width of the floor");
    v("wall_height_m", wall_height_m, 0.0, 10.0, "height of the upright walls below the arch");
    v("round", round, "a round pipe of this width, without floor and walls");
    v("curvature_per_m", curvature_per_m, -0.1, 0.1, "1/radius of the bend, positive to the left");
    v("gradient", gradient, -0.2, 0.2, "rise per metre");
    v("segment_m", segment_m, 0.0, 2000.0, "mean length of segments that bend differently, 0: one");
    v("segment_curvature_per_m", segment_curvature_per_m, 0.0, 0.1, "largest 1/radius of segments");
    v("segment_gradient", segment_gradient, 0.0, 0.2, "largest gradient of segments");
    v("cabinet_every_m", cabinet_every_m, 0.0, 1000.0, "mean distance of cabinets, 0 for none");
    v("roughness_m", roughness_m, 0.0, 1.0, "unevenness of walls and arch");
    v("niche_every_m", niche_every_m, 0.0, 1000.0, "distance of niches, 0 for none");
    v("reflectivity", reflectivity, 0.01, 1.0, "of all surfaces");
    v("closed_ends", closed_ends, "a wall across each end");
  }
};

/// Drift through rock: rough walls, uneven floor, props and rubble, random bends.
struct MineOptions {
  double length_m = 110.0;
  double width_m = 4.4;
  double wall_height_m = 1.1;
  double bend_deg = 40.0;     ///< largest turn from one segment to the next
  double gradient = 0.01;     ///< rise per metre
  double roughness_m = 0.30;  ///< of walls and roof
  double clutter_every_m = 6.5;

  template <class V>
  void visit(V& v) {
    v("length_m", length_m, 20.0, 5000.0, "length along the axis");
    v("width_m", width_m, 2.5, 12.0, "width of the floor");
    v("wall_height_m", wall_height_m, 0.5, 6.0, "height of the walls below the roof's arch");
    v("bend_deg", bend_deg, 0.0, 60.0, "largest turn between pieces of about 25 m");
    v("gradient", gradient, -0.15, 0.15, "rise per metre");
    v("roughness_m", roughness_m, 0.0, 0.6, "unevenness of walls and roof");
    v("clutter_every_m", clutter_every_m, 0.0, 100.0, "distance of props and rubble, 0 for none");
  }
};

/// Helical ramp between two level halls.
struct RampOptions {
  double radius_m = 9.0;  ///< of the middle of the lane
  double rise_m = 3.0;    ///< per turn
  int turns = 2;
  double width_m = 4.2;
  double height_m = 2.15;  ///< of the ceiling over the lane

  template <class V>
  void visit(V& v) {
    v("radius_m", radius_m, 5.0, 30.0, "radius of the middle of the lane");
    v("rise_m", rise_m, 2.5, 10.0, "rise per turn");
    v("turns", turns, 1, 20, "full turns");
    v("width_m", width_m, 3.0, 10.0, "width of the lane");
    v("height_m", height_m, 1.8, 8.0, "height of the ceiling over the lane");
  }
};

/// Errors (kUsage): the curvature closes a circle within the length.
[[nodiscard]] Result<World> tunnel_world(const TunnelOptions& options, Rng rng);

[[nodiscard]] World mine_world(const MineOptions& options, Rng rng);

/// Errors (kUsage): the turns overlap in height, or the inner wall has no radius.
[[nodiscard]] Result<World> ramp_world(const RampOptions& options, Rng rng);

}  // namespace rali::sim
