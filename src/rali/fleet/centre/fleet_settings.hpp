#pragma once

#include "rali/base/settings.hpp"
#include "rali/fleet/centre/loop_search.hpp"
#include "rali/fleet/centre/path_submaps.hpp"
#include "rali/fleet/centre/settings.hpp"
#include "rali/fleet/frames/settings.hpp"
#include "rali/places/settings.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::fleet {

/// Settings of room `fleet`.
struct FleetSettings {
  bool join = true;
  InitSettings init;
  CutSettings cut;
  LoopSettings loops;
  SolveWhat solve = SolveWhat::kAll;
  SeparatorSettings separator;
  JointSettings joint;
  places::PlacesSettings places;
  ranging::RangingSettings ranging;  ///< as the vehicles use it

  template <class V>
  void visit(V& v) {
    v("join", join, "make one map of all vehicles");
    v.group("init", init, "frames between vehicles");
    v.group("cut", cut, "submaps that are compared");
    v.group("loops", loops, "loop closures");
    v.choice("solve", solve, kSolveWhatNames, "what is solved anew with each estimate");
    v.group("separator_prior", separator, "separator priors of earlier rounds");
    v.group("joint", joint, "the joint graph");
    v.group("places", places, "how places are recognised");
  }
};

}  // namespace rali::fleet
