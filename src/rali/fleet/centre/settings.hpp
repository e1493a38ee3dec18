#pragma once

#include "rali/base/settings.hpp"
#include "rali/fleet/path/shape.hpp"
#include "rali/graph/settings.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::fleet {

/// Weight of a step of a path in the joint graph.
enum class StepWeight {
  kAware,     ///< LiDAR where observable, inertial data where degenerate (algorithms_fleet 8.2)
  kIsotropic  ///< the same in all directions, as the paper seems to do
};
inline constexpr ChoiceNames<2> kStepWeightNames = {"aware", "isotropic"};

/// Scope of the centre's solution.
enum class SolveWhat {
  kAll,    ///< everything, from all facts
  kRounds  ///< the current round, with a prior from the earlier ones (algorithms_fleet 8.5)
};
inline constexpr ChoiceNames<2> kSolveWhatNames = {"all", "rounds"};

/// Which loop to an earlier round causes a new solution of everything.
enum class ReopenBy {
  kMisfit,  ///< one that contradicts the current estimate
  kAny      ///< as in the paper
};
inline constexpr ChoiceNames<2> kReopenByNames = {"misfit", "any"};

/// Estimates by rounds.
struct SeparatorSettings {
  ReopenBy reopen = ReopenBy::kMisfit;
  double moved_sigma = 3.0;
  double moved_m = 0.01;
  int kept = 100;
  int near_rounds = 3;
  double warm_up_s = 60.0;
  double same_place_m = 2.0;
  double same_place_deg = 20.0;

  template <class V>
  void visit(V& v) {
    v.choice("reopen", reopen, kReopenByNames, "which loops to earlier rounds solve these again");
    v("shift_sigma", moved_sigma, 0.5, 1e6,
      "a separator prior that shifts by more of its sigma is derived again from an earlier one");
    v("shift_m", moved_m, 0.0, 10.0, "and by so much more [m, rad]");
    v("kept", kept, 0, 10000,
      "boundaries of earlier rounds to go back to; where none is left all facts are solved");
    v("near_rounds", near_rounds, 0, 1000,
      "loops into so many of the rounds before the last are closed whether they fit or not");
    v("warm_up_s", warm_up_s, 0.0, 3600.0,
      "time before the separator whose ranges set the weight of the next [s]");
    v("same_place_m", same_place_m, 0.0, 100.0,
      "a submap this near to one of an earlier round is dropped [m]");
    v("same_place_deg", same_place_deg, 0.0, 180.0, "nor one turned by less");
  }
};

/// The joint graph of the fleet (algorithms_fleet 8). The defaults are those of `robust`.
struct JointSettings {
  StepWeight steps = StepWeight::kAware;
  double isotropic_m = 0.05;
  double isotropic_deg = 0.5;
  bool bias = true;
  bool sight = true;
  int rounds = 3;
  int iterations = 30;
  int iterations_easy = 30;
  int inertial_margin = 3;
  double lost_m = 5.0;
  double lost_rad = 0.5;
  double tilt_deg = 0.3;
  double tilt_unlevelled_deg = 5.0;
  int tilt_every = 20;
  double start_speed_sigma_mps = 0.05;
  double start_gyro_bias_sigma_radps = 0.002;
  double start_accel_bias_sigma_mps2 = 0.05;
  double path_sigma_m = 0.1;
  double stretch_sd = 2.0;
  ShapeSettings shape;
  graph::GraphSettings graph;

  template <class V>
  void visit(V& v) {
    v.choice("steps", steps, kStepWeightNames, "weight of a step of a path");
    v("isotropic_m", isotropic_m, 1e-4, 10.0, "sigma of a step, where steps are isotropic");
    v("isotropic_deg", isotropic_deg, 1e-3, 90.0, "the same of its turn");
    v("bias", bias, "estimate what each pair of radios measures too much");
    v("line_of_sight", sight,
      "ranges through walls of the maps of all vehicles get a larger sigma "
      "(ranging.line_of_sight)");
    v("rounds", rounds, 1, 20, "solutions, each with the ranges classified again");
    v("iterations", iterations, 1, 1000, "of each solution");
    v("iterations_easy", iterations_easy, 1, 1000, "the same where no step was degenerate");
    v("inertial_margin", inertial_margin, 0, 1000,
      "nodes around a degenerate one whose speed is estimated too");
    v("lost_m", lost_m, 1e-2, 1e3, "sigma of the step to a new map after the old one was lost");
    v("lost_rad", lost_rad, 1e-3, 10.0, "the same of its turn");
    v("tilt_deg", tilt_deg, 1e-3, 90.0,
      "sigma of roll and pitch, added to what the odometry states");
    v("tilt_unlevelled_deg", tilt_unlevelled_deg, 1e-3, 90.0, "the same without inertial data");
    v("tilt_every", tilt_every, 1, 100000, "nodes between two gravity factors");
    v("start_speed_sigma_mps", start_speed_sigma_mps, 1e-4, 100.0,
      "sigma of the first inertial node's speed");
    v("start_gyro_bias_sigma_radps", start_gyro_bias_sigma_radps, 1e-6, 1.0, "the same");
    v("start_accel_bias_sigma_mps2", start_accel_bias_sigma_mps2, 1e-5, 10.0,
      "the same of its accelerometer bias and gravity together, if its odometry does not state it");
    v("path_sigma_m", path_sigma_m, 0.0, 10.0,
      "sigma of the path when ranges are classified again");
    v("common_error_sd", stretch_sd, 0.0, 1e6,
      "ranges with a common error above so many sigma of their mean get a lower weight; 0: never");
    v.group("shape", shape, "what ties the nodes of a path together");
    v.group("graph", graph, "the solver");
  }
};

}  // namespace rali::fleet
