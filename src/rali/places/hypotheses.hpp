#pragma once

#include <optional>
#include <vector>

#include "rali/places/density.hpp"
#include "rali/places/guess.hpp"

namespace rali::places {

struct HypothesisSettings {
  BandSettings band;
  double cell_m = 0.2;  ///< of the finest pictures; the search begins at twice this
  double yaw_step_deg = 3.0;
  int peaks_max = 20;
  double apart_m = 1.0;        ///< peaks nearer than this and
  double apart_deg = 10.0;     ///< turned less are one
  double min_fraction = 0.25;  ///< of the best correlation; less is no peak
  double ridge_fraction =
      0.5;  ///< of the best correlation, that a place beside it needs to form a ridge
  double ridge_step_m = 1.0;    ///< spacing of the places kept along it
  double ridge_reach_m = 12.0;  ///< length of a ridge, to either side
  double gate = 3.5;            ///< of a guess, in sigma

  template <class V>
  void visit(V& v) {
    v.group("band", band, "height band of the image from above");
    v("cell_m", cell_m, 0.05, 2.0, "cell of the images");
    v("yaw_step_deg", yaw_step_deg, 0.5, 30.0, "step of the yaw that is tried");
    v("peaks_max", peaks_max, 1, 1000, "places that are kept");
    v("apart_m", apart_m, 0.1, 20.0, "places nearer than this are one");
    v("apart_deg", apart_deg, 1.0, 180.0, "places turned less than this are one");
    v("min_fraction", min_fraction, 0.0, 1.0, "of the best correlation that a place must have");
    v("ridge_fraction", ridge_fraction, 0.0, 1.0, "of the best correlation that makes a ridge");
    v("ridge_step_m", ridge_step_m, 0.1, 10.0, "spacing of places along a ridge");
    v("ridge_reach_m", ridge_reach_m, 1.0, 100.0, "places along a ridge to both sides");
    v("gate", gate, 1.0, 20.0, "candidates within so many sigma of a guess are kept");
  }
};

/// A candidate alignment of two submaps' pictures: 4 parameters, roll and pitch are zero.
struct Hypothesis {
  geometry::SE3 T_a_b;
  double correlation = 0.0;  ///< fraction of b's marks on a's; rewards overlap, proves nothing
  bool on_ridge = false;     ///< kept because of the ridge, not as a peak
};

/// In a corridor the pictures match all along: yaw and lateral offset are right, ranges or
/// verification must determine the position along it.
struct Ridge {
  geometry::SE3 T_a_b;                                   ///< its best place
  geometry::Vec3 direction_a = geometry::Vec3::UnitX();  ///< unit, horizontal
  double from_m = 0.0, to_m = 0.0;  ///< along the direction, about the best place
};

struct Hypotheses {
  std::vector<Hypothesis> places;  ///< peaks by falling correlation, then those on ridges
  std::vector<Ridge> ridges;       ///< of the best place and of its opposite
};

/// Candidate poses of b in a, by correlation of height-band pictures over all yaws
/// (algorithms_fleet 7.4 step 2). Do not rank by correlation: the true pose may have a fraction of
/// the best one. @param guess only poses within its gate, if given. Height aligns the two grounds.
/// Empty if a picture is empty.
[[nodiscard]] Hypotheses global_hypotheses(const Submap& a, const Submap& b,
                                           const HypothesisSettings& settings,
                                           const std::optional<Guess>& guess = {});

}  // namespace rali::places
