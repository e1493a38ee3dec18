#pragma once

#include "rali/base/settings.hpp"
#include "rali/ranging/paper_settings.hpp"

namespace rali::ranging {

/// Accuracy of a range, and limits of valid ones (algorithms 4.1, 4.3).
struct RangeLimits {
  double near_m = 0.3;   ///< below: no direction, near field
  double far_m = 300.0;  ///< no such radio reaches farther
  double sigma_m = 0.10;
  double sigma_per_m = 0.001;
  double sigma_min_m = 0.01;   ///< a smaller sigma of a recording is raised to this
  double bent_max_m = 1.0;     ///< a range with a larger second-order term is not used
  double speed_max_mps = 6.0;  ///< of the two ends relative to each other

  template <class V>
  void visit(V& v) {
    v("near_m", near_m, 0.0, 10.0, "shorter ranges are left out");
    v("far_m", far_m, 1.0, 10000.0, "longer ranges are left out");
    v("sigma_m", sigma_m, 0.001, 10.0, "sigma of a range in line of sight");
    v("sigma_per_m", sigma_per_m, 0.0, 0.1, "and per metre of it, added in squares");
    v("sigma_min_m", sigma_min_m, 1e-4, 1.0, "lower bound of the sigma of a recorded range");
    v("bent_max_m", bent_max_m, 0.01, 100.0,
      "sigma of the linearisation error near an antenna of uncertain position");
    v("speed_max_mps", speed_max_mps, 0.1, 100.0, "how fast a range can change");
  }
};

/// Line of sight by the two signal strengths of a range (algorithms 4.3, step 2).
struct SignalSettings {
  double clear_db = 6.0;
  double blocked_db = 10.0;
  double blocked_factor = 5.0;
  double beyond_factor = 10.0;
  double p_los_clear = 0.8;
  double p_los_blocked = 0.1;

  template <class V>
  void visit(V& v) {
    v("clear_db", clear_db, 0.0, 60.0,
      "power above the first path up to which the line of sight is free");
    v("blocked_db", blocked_db, 0.0, 60.0, "and from which it is blocked");
    v("blocked_factor", blocked_factor, 1.0, 100.0, "on sigma at blocked_db, rising from 1");
    v("beyond_factor", beyond_factor, 1.0, 1000.0, "on sigma above blocked_db");
    v("p_los_clear", p_los_clear, 0.0, 1.0, "probability of line of sight up to clear_db");
    v("p_los_blocked", p_los_blocked, 0.0, 1.0, "and from blocked_db on");
  }
};

/// Which ranges of one pair contradict their neighbours in time (algorithms 4.3, step 1).
struct SanitySettings {
  double speed_margin_mps = 1.0;
  double jump_sigmas = 4.0;
  int resync_count = 5;
  int frozen_count = 10;
  double frozen_moved_m = 0.5;

  template <class V>
  void visit(V& v) {
    v("speed_margin_mps", speed_margin_mps, 0.0, 100.0, "added to the largest speed");
    v("jump_sigmas", jump_sigmas, 0.0, 100.0, "a range may change so much on the spot");
    v("resync_count", resync_count, 1, 1000, "so many that agree with each other are accepted");
    v("frozen_count", frozen_count, 2, 10000, "so many equal values can be a frozen radio");
    v("frozen_moved_m", frozen_moved_m, 0.0, 100.0, "if the range should have changed so much");
  }
};

/// Gate of ranges against the prediction, and their weights (algorithms 4.3, steps 4 and 5).
struct GateSettings {
  double chi2 = 10.83;  ///< 0.1 % of good ranges are above
  double longer_scale = 1.5;
  double shorter_scale = 2.5;
  double one_sided_above = 2.0;
  double huber = 2.0;

  template <class V>
  void visit(V& v) {
    v("chi2", chi2, 1.0, 1000.0, "larger normalised squares of the residual are left out");
    v("longer_scale", longer_scale, 0.1, 100.0, "sigmas at which the weight of a long range falls");
    v("shorter_scale", shorter_scale, 0.1, 100.0, "the same for a short range");
    v("one_sided_above", one_sided_above, 0.0, 100.0,
      "sigmas from which a long range is classified as blocked");
    v("huber", huber, 0.1, 100.0,
      "sigmas from which a range gets a lower weight, below one_sided_above");
  }
};

/// When a link is not used for a while (algorithms 4.3, step 6).
struct LinkSettings {
  int window = 20;
  double suspect_fraction = 0.5;
  int reacquire_count = 10;
  double offset_sigmas = 2.0;
  double longer_s = 8.0;
  double widen_factor = 4.0;
  int widen_max = 3;
  double lost_s = 2.0;

  template <class V>
  void visit(V& v) {
    v("window", window, 2, 1000, "ranges that are classified together");
    v("suspect_fraction", suspect_fraction, 0.0, 1.0,
      "with more of them rejected the link is suspect");
    v("reacquire_count", reacquire_count, 1, 1000, "fitting ranges in a row that end that");
    v("offset_sigmas", offset_sigmas, 0.1, 100.0, "spread around one offset: the pose is wrong");
    v("longer_s", longer_s, 0.0, 3600.0, "but ranges that are too long only after so long");
    v("widen_factor", widen_factor, 1.0, 100.0, "on the covariance of a pose that is wrong");
    v("widen_max", widen_max, 0, 100, "widenings before a warning");
    v("lost_s", lost_s, 0.1, 1000.0, "silence after which a link is lost");
  }
};

/// The slow part of the error of ranges: multipath and the radio's own.
struct SlowErrorSettings {
  double slow_sigma_m = 0.06;
  double slow_time_s = 4.0;

  template <class V>
  void visit(V& v) {
    v("slow_sigma_m", slow_sigma_m, 0.0, 10.0, "sd of the part of the error that wanders");
    v("slow_time_s", slow_time_s, 0.001, 10000.0, "its correlation time");
  }
};

/// When ranges of both directions of a pair are one measurement (algorithms 4.7).
struct ExchangeSettings {
  double slot_s = 0.02;
  double agree_m = 0.3;
  int history = 1000;

  template <class V>
  void visit(V& v) {
    v("slot_s", slot_s, 0.0, 1.0, "both directions within half of it are one exchange");
    v("agree_m", agree_m, 0.0, 100.0, "unless they differ by more");
    v("history", history, 1, 1000000, "ranges of a pair kept to find repeats");
  }
};

/// Time of a radio's own clock on the host's clock (algorithms 4.6).
struct ArrivalClockSettings {
  double window_s = 60.0;
  double slope_max_ppm = 100.0;
  double restart_s = 1.0;
  int restart_count = 10;

  template <class V>
  void visit(V& v) {
    v("window_s", window_s, 1.0, 3600.0, "length of the arrivals looked at");
    v("slope_max_ppm", slope_max_ppm, 0.0, 10000.0, "largest drift of the two clocks");
    v("restart_s", restart_s, 0.01, 3600.0,
      "larger jumps of the device's clock restart the estimate");
    v("restart_count", restart_count, 1, 10000, "arrivals later than that before it does");
  }
};

/// Estimation of the position of an antenna at standstill, from ranges to it (anchor_finder.hpp).
struct FinderSettings {
  double spacing_m = 0.2;
  double spacing_s = 2.0;
  int samples_min = 8;
  int samples_max = 150;
  double travel_min_m = 2.0;
  double travel_again_m = 0.5;
  double height_sigma_m = 0.3;
  double speed_sigma_min_mps = 0.005;
  int directions = 16;
  int iterations = 30;
  double huber = 2.0;
  double merge_m = 0.3;
  double rival_chi2 = 13.8;
  double chi2_max = 2.5;
  double sigma_max_m = 0.4;
  double passage_m = 2.0;
  double passage_per_m = 0.05;
  double bend_radius_m = 100.0;
  double wall_m = 0.5;
  double walls_far_m = 10.0;
  double walls_sigma_m = 0.1;
  double walls_turn_rad = 0.64;
  double walls_own_m = 0.2;
  double walls_every_m = 0.5;
  double report_sigmas = 3.0;
  double roughly_m = 1.0;
  double rise_per_m = 0.02;

  template <class V>
  void visit(V& v) {
    v("spacing_m", spacing_m, 0.0, 10.0, "distance travelled between ranges that are used");
    v("spacing_s", spacing_s, 0.0, 600.0, "or time, at standstill");
    v("samples_min", samples_min, 5, 10000, "ranges needed");
    v("samples_max", samples_max, 10, 10000, "ranges kept, the last ones");
    v("travel_min_m", travel_min_m, 0.0, 100.0, "distance travelled before the first solution");
    v("travel_again_m", travel_again_m, 0.0, 100.0, "distance travelled before the next attempt");
    v("height_sigma_m", height_sigma_m, 0.01, 100.0,
      "sigma of the height difference of two vehicles");
    v("speed_sigma_min_mps", speed_sigma_min_mps, 1e-5, 10.0, "smallest sigma of the own speed");
    v("directions", directions, 4, 360, "directions in which the search starts");
    v("iterations", iterations, 1, 1000, "of each search");
    v("huber", huber, 0.1, 100.0, "sigmas from which a range gets a lower weight");
    v("merge_m", merge_m, 0.01, 10.0, "nearer solutions are one");
    v("rival_chi2", rival_chi2, 0.0, 1000.0, "a rival is refuted by so much (13.8: odds 1000)");
    v("chi2_max", chi2_max, 0.1, 100.0, "squares per range that a solution may leave");
    v("sigma_max_m", sigma_max_m, 0.01, 100.0, "sigma below which the landmark is used");
    v("passage_m", passage_m, 0.1, 100.0,
      "sigma of the lateral position of a peer in a passage without walls in view");
    v("passage_per_m", passage_per_m, 0.0, 1.0, "and so much more per metre, for its bends");
    v("bend_radius_m", bend_radius_m, 1.0, 1e6, "but no more than an arc of this radius bends");
    v("wall_m", wall_m, 0.05, 100.0, "smallest distance of a vehicle to a wall");
    v("walls_far_m", walls_far_m, 0.5, 100.0, "largest distance of a wall that is used");
    v("walls_sigma_m", walls_sigma_m, 0.001, 10.0,
      "sigma of the lateral offset of two vehicles, from their distances to walls");
    v("walls_turn_rad", walls_turn_rad, 0.0, 1.5, "a passage turns no more than this between two");
    v("walls_own_m", walls_own_m, 0.0, 5.0, "nearer than this is a part of the vehicle itself");
    v("walls_every_m", walls_every_m, 0.01, 10.0,
      "spacing of the five positions at which walls are measured");
    v("report_sigmas", report_sigmas, 0.5, 100.0,
      "error in sigmas from which a vehicle's report is not used");
    v("roughly_m", roughly_m, 0.01, 100.0,
      "sigma of a landmark initialised from the peer's report, before its first range");
    v("rise_per_m", rise_per_m, 0.0, 1.0, "how much it may rise or fall unseen");
  }
};

/// Steps in the residuals of a pair (excess_watch.hpp).
struct ExcessSettings {
  bool use = true;
  int level_min = 5;
  int level_samples = 9;
  int noise_samples = 20;
  int noise_window = 60;
  double step_min_m = 0.2;
  double step_sigmas = 4.0;
  int step_samples = 3;
  double longest_s = 60.0;
  double end_fraction = 0.4;
  double memory_s = 10.0;

  template <class V>
  void visit(V& v) {
    v("use", use, "ranges that become longer in a step are classified as blocked");
    v("level_min", level_min, 1, 1000, "ranges before a step can be detected");
    v("level_samples", level_samples, 1, 1000, "whose median is the level before a step");
    v("noise_samples", noise_samples, 3, 10000, "before the noise is taken from the ranges");
    v("noise_window", noise_window, 3, 10000, "whose changes are the noise");
    v("step_min_m", step_min_m, 0.0, 100.0, "smaller steps are left to the weights");
    v("step_sigmas", step_sigmas, 1.0, 100.0, "sds of the noise that a step stands out");
    v("step_samples", step_samples, 1, 1000, "ranges in a row on one side that make a step");
    v("longest_s", longest_s, 0.1, 3600.0, "an excess that lasts longer is accepted as distance");
    v("end_fraction", end_fraction, 0.0, 1.0, "of the step, that a step down must have to end it");
    v("memory_s", memory_s, 0.1, 3600.0, "how far back ranges are compared");
  }
};

/// The constant error of a pair of antennas (algorithms 4.4) and of the stamps (4.5).
struct BiasSettings {
  double sigma_m = 0.1;
  double walk_m_rts = 0.001;
  double tau_sigma_s = 0.02;
  double tau_walk_s_rts = 1e-4;

  template <class V>
  void visit(V& v) {
    v("sigma_m", sigma_m, 1e-4, 10.0, "sigma of the bias of a pair before it is estimated");
    v("walk_m_rts", walk_m_rts, 0.0, 1.0, "how fast it wanders [m/sqrt(s)]");
    v("tau_sigma_s", tau_sigma_s, 0.0, 10.0, "sigma of the stamps' offset");
    v("tau_walk_s_rts", tau_walk_s_rts, 0.0, 1.0, "how fast it wanders [s/sqrt(s)]");
  }
};

/// Passing an antenna of unknown lateral position in a passage (landmark_mixture.hpp).
struct MixtureSettings {
  bool use = true;
  double uncertainty_m = 0.4;
  double known_m = 0.15;
  double slice_m = 0.4;
  double reach_sigmas = 3.0;
  int slices_max = 80;
  double weight_min = 1e-4;
  double wild_fraction = 0.02;
  double wild_sigma_m = 2.0;
  double past_m = 6.0;
  double patience_s = 2.0;

  template <class V>
  void visit(V& v) {
    v("use", use, "the lateral position of a peer in a passage is a mixture of slices");
    v("uncertain_m", uncertainty_m, 0.05, 100.0, "lateral sigma from which the mixture starts");
    v("known_m", known_m, 0.01, 100.0, "sigma below which the slices are merged");
    v("slice_m", slice_m, 0.05, 10.0, "between slices");
    v("reach_sigmas", reach_sigmas, 1.0, 10.0, "how far they reach to both sides");
    v("slices_max", slices_max, 1, 1000, "wider ones if it were more");
    v("weight_min", weight_min, 0.0, 0.1, "over their number: lighter slices are dropped");
    v("outlier_fraction", wild_fraction, 0.0, 1.0, "fraction of outliers among the ranges");
    v("outlier_sigma_m", wild_sigma_m, 0.1, 1000.0, "sigma of an outlier");
    v("past_m", past_m, 0.5, 1000.0, "farther than at the nearest, the other is passed");
    v("patience_s", patience_s, 0.0, 3600.0,
      "time without a degenerate axis before the slices are merged");
  }
};

/// Whether the map has walls between two antennas (algorithms 4.3, step 3).
struct SightSettings {
  bool use = true;
  int surfaces = 2;
  double end_m = 0.5;
  double sigma_factor = 5.0;
  double valid_s = 0.25;
  double valid_m = 0.25;

  template <class V>
  void visit(V& v) {
    v("use", use, "ranges through walls of the map get a larger sigma");
    v("surfaces", surfaces, 1, 100, "surfaces crossed from which the line of sight is blocked");
    v("end_m", end_m, 0.0, 10.0, "left out at both antennas");
    v("sigma_factor", sigma_factor, 1.0, 100.0, "on sigma behind a wall");
    v("valid_s", valid_s, 0.0, 10.0, "how long an answer holds");
    v("valid_m", valid_m, 0.0, 10.0, "and how far the vehicle may move meanwhile");
  }
};

/// Settings of the ranging module.
struct RangingSettings {
  bool use = true;  ///< false: ranges are read and reported, nothing more
  RangeLimits limits;
  SignalSettings signal;
  SanitySettings sanity;
  GateSettings gate;
  LinkSettings link;
  SlowErrorSettings slow;
  ExcessSettings excess;
  BiasSettings bias;
  MixtureSettings mixture;
  SightSettings sight;
  FinderSettings finder;
  double place_lost_s = 8.0;    ///< time without a fit until a landmark is initialised again
  double place_stay_m = 0.1;    ///< reported motion below which a peer has not left
  double place_silent_s = 1.0;  ///< time without ranges after which that time starts again
  double status_valid_s = 1.5;  ///< how long a reported standstill is valid
  ExchangeSettings exchange;
  ArrivalClockSettings arrival;
  PaperRangeSettings paper;

  template <class V>
  void visit(V& v) {
    v("use", use, "ranges move the poses; false: they are only reported");
    v.group("limits", limits, "what can be a range");
    v.group("signal", signal, "line of sight by signal strengths");
    v.group("sanity", sanity, "ranges that contradict their neighbours in time");
    v.group("gate", gate, "ranges that do not fit the prediction");
    v.group("link", link, "links that are not used for a while");
    v.group("slow", slow, "common error of neighbouring ranges");
    v.group("excess", excess, "ranges that become longer from one to the next");
    v.group("bias", bias, "constant error of a pair");
    v.group("mixture", mixture, "passing an antenna of unknown lateral position");
    v.group("line_of_sight", sight, "walls of the map between the antennas");
    v.group("initialisation", finder, "initialisation of the landmark of a vehicle at standstill");
    v("landmark_lost_s", place_lost_s, 0.5, 3600.0,
      "time with ranges of which none fits, after which the landmark is initialised again");
    v("landmark_stay_m", place_stay_m, 0.0, 10.0,
      "reported motion below which a landmark keeps its position");
    v("landmark_silent_s", place_silent_s, 0.0, 3600.0,
      "time without ranges after which that starts again");
    v("status_valid_s", status_valid_s, 0.1, 60.0,
      "time for which a reported standstill of a peer is valid");
    v.group("exchange", exchange, "both directions of one exchange");
    v.group("arrival", arrival, "radios whose stamps are of their own clock");
    v.group("paper", paper, "ranges as the paper uses them");
  }
};

}  // namespace rali::ranging
