#pragma once

#include <cstdint>

#include "rali/base/settings.hpp"

namespace rali::fleet {

enum class FinishRule : std::uint8_t { kPaper, kRobust };
inline constexpr ChoiceNames<2> kFinishRuleNames = {"paper", "robust"};

/// When a tag has finished its part of a round (algorithms_fleet 10.1).
struct FinishSettings {
  FinishRule rule = FinishRule::kRobust;
  double rssi_stop_dbm = -85.0;
  double rssi_window_s = 2.0;
  double max_distance_m = 60.0;
  double explored_hold_s = 5.0;
  double range_lost_s = 5.0;
  double max_sigma_m = 0.3;
  double sigma_beyond_m = 5.0;
  double warn_rssi_db = 5.0;   ///< no goals farther out from here on
  double warn_distance = 0.1;  ///< likewise, fraction of max_distance_m
  double battery_min = 0.1;    ///< fraction

  /// Distance to the anchor beyond which no goal leads farther away [m].
  [[nodiscard]] double warn_from_m() const { return max_distance_m * (1.0 - warn_distance); }

  template <class V>
  void visit(V& v) {
    v.choice("rule", rule, kFinishRuleNames, "conditions of the paper, or more");
    v("rssi_stop_dbm", rssi_stop_dbm, -130.0, 0.0, "weaker radio ends the exploration [dBm]");
    v("rssi_window_s", rssi_window_s, 0.1, 60.0, "its median is taken over this time [s]");
    v("max_distance_m", max_distance_m, 1.0, 10000.0, "farther from the anchor likewise [m]");
    v("explored_hold_s", explored_hold_s, 0.0, 600.0, "no frontier for this long likewise [s]");
    v("range_lost_s", range_lost_s, 0.5, 600.0, "degenerate and without range for this long [s]");
    v("max_sigma_m", max_sigma_m, 0.01, 100.0, "growth of the position sigma within the round [m]");
    v("sigma_beyond_m", sigma_beyond_m, 0.0, 1000.0,
      "the rule above holds only farther from the anchor than this [m]");
    v("warn_rssi_db", warn_rssi_db, 0.0, 50.0, "no goals further out, this much before [dB]");
    v("warn_distance", warn_distance, 0.0, 1.0, "likewise, as a fraction of the distance");
    v("battery_min", battery_min, 0.0, 1.0, "fraction of the battery likewise");
  }
};

enum class AnchorChoice : std::uint8_t { kPaper, kInformed };
inline constexpr ChoiceNames<2> kAnchorChoiceNames = {"paper", "informed"};

enum class AnchorCandidates : std::uint8_t { kTags, kAll };
inline constexpr ChoiceNames<2> kAnchorCandidatesNames = {"tags", "all"};

enum class FrontierDistance : std::uint8_t { kEuclid, kPath };
inline constexpr ChoiceNames<2> kFrontierDistanceNames = {"euclid", "path"};

/// Choice of the next anchor (algorithms_fleet 10.3).
struct AnchorSettings {
  AnchorChoice choice = AnchorChoice::kInformed;
  AnchorCandidates candidates = AnchorCandidates::kAll;
  FrontierDistance distance = FrontierDistance::kPath;
  double range_limit_m = 60.0;  ///< the link probability is one half here
  double range_soft_m = 8.0;    ///< width of that change
  double c_sat = 0.5;           ///< cosine to the degenerate axis that is sufficient
  double path_cost = 0.02;      ///< per metre
  double near_m = 5.0;          ///< places this close to a vehicle are considered, too
  double spacing_m = 2.0;       ///< of predicted places

  template <class V>
  void visit(V& v) {
    v.choice("choice", choice, kAnchorChoiceNames, "nearest to the largest frontier, or useful");
    v.choice("candidates", candidates, kAnchorCandidatesNames, "whether the anchor may stay it");
    v.choice("distance", distance, kFrontierDistanceNames, "to the frontier: straight or driven");
    v("range_limit_m", range_limit_m, 1.0, 10000.0, "half of the ranges arrive here [m]");
    v("range_soft_m", range_soft_m, 0.1, 1000.0, "width of that change [m]");
    v("c_sat", c_sat, 0.01, 1.0, "fraction of the degenerate axis in view that is enough");
    v("path_cost", path_cost, 0.0, 10.0, "value of a metre not driven");
    v("near_m", near_m, 0.0, 50.0, "positions this near to a vehicle are evaluated too [m]");
    v("spacing_m", spacing_m, 0.2, 50.0, "distance of predicted places [m]");
  }
};

/// Choice of goals (algorithms_fleet 10.4).
struct GoalSettings {
  double size_weight = 0.5;      ///< of a frontier, against metres of path
  double link_min = 0.5;         ///< probability of a range to a vehicle at standstill, all along
                                 ///< the path
  bool pass_anchor = true;       ///< start behind or beside the anchor and drive past it
  double pass_side_m = 1.2;      ///< distance to the anchor, where a pass is planned
  double passed_m = 4.0;         ///< passed if nearer than this
  double pass_detour_m = 15.0;   ///< a path past it may be this much longer
  double beside_m = 0.8;         ///< distance of paths from vehicles at standstill, ...
  double around_m = 2.0;         ///< ... and if a vehicle could not pass
  double frontier_back_m = 0.5;  ///< stop this much before the frontier

  template <class V>
  void visit(V& v) {
    v("size_weight", size_weight, 0.0, 100.0, "metres that a unit of frontier size is worth");
    v("link_min", link_min, 0.0, 1.0, "least probability of a range at each point of a path");
    v("pass_anchor", pass_anchor,
      "lead paths past the anchor, which makes the bias of the pair observable");
    v("pass_side_m", pass_side_m, 0.3, 20.0, "distance at which it is passed [m]");
    v("passed_m", passed_m, 0.3, 50.0, "nearer than this is passed [m]");
    v("pass_detour_m", pass_detour_m, 0.0, 500.0, "a path past it is at most this much longer [m]");
    v("beside_m", beside_m, 0.0, 5.0, "distance of paths from vehicles at standstill [m]");
    v("around_m", around_m, 0.0, 20.0, "likewise, of a vehicle that could not get past [m]");
    v("frontier_back_m", frontier_back_m, 0.0, 20.0, "stop this much before a frontier [m]");
  }
};

enum class RoundMode : std::uint8_t { kRoles, kNone, kAuto };
inline constexpr ChoiceNames<3> kRoundModeNames = {"roles", "none", "auto"};

/// Settings of the rounds.
struct RoundSettings {
  RoundMode mode = RoundMode::kAuto;
  double stand_min_s = 3.0;  ///< standstill of this length makes an anchor (10.6)
  double evaluations = 2.0;  ///< consecutive ones without frontier end the mission
  FinishSettings finish;
  AnchorSettings anchor;
  GoalSettings goals;

  template <class V>
  void visit(V& v) {
    v.choice("mode", mode, kRoundModeNames, "rounds by roles, or by standstill");
    v("standstill_min_s", stand_min_s, 0.5, 600.0, "standstill that makes an anchor [s]");
    v("evaluations", evaluations, 1.0, 100.0, "searches without frontier that end the mission");
    v.group("finish", finish, "end of a tag's exploration");
    v.group("anchor", anchor, "choice of the next anchor");
    v.group("goals", goals, "which vehicle drives to which goal");
  }
};

}  // namespace rali::fleet
