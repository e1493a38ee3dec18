#pragma once

#include <utility>

#include "rali/base/settings.hpp"
#include "rali/fleet/centre/fleet_settings.hpp"
#include "rali/fleet/facts/exchange_settings.hpp"
#include "rali/fleet/roles/role_state.hpp"
#include "rali/fleet/rounds/settings.hpp"
#include "rali/map/explore_settings.hpp"
#include "rali/map/frontiers.hpp"

namespace rali::fleet {

/// One vehicle's part in the fleet.
struct NodeSettings {
  /// A start pose measured by tape and eye (0.2 m, 3 deg) is sufficient to start driving: without
  /// motion the uncertainty never shrinks, so a higher threshold would block the mission. Each
  /// estimate starts from scratch. A mission is long, so only the current round is solved anew.
  NodeSettings() {
    fleet.init.commit.information_min = 0.05;
    fleet.solve = SolveWhat::kRounds;
  }

  /// Takes the settings given for offline maps, except those that a mission must override.
  void take(const FleetSettings& given) {
    const FleetSettings own = std::exchange(fleet, given);
    fleet.init.commit.information_min = own.init.commit.information_min;
    fleet.solve = own.solve;
  }

  double status_s = 1.0;
  double estimate_s = 10.0;
  double estimate_fraction = 0.1;
  double look_s = 2.0;
  double moved_m = 0.02;
  double rest_s = 1.0;
  double arrive_m = 2.0;
  double taken_m = 4.0;
  double choice_wait_s = 15.0;
  double back_m = 3.0;
  double lost_s = 30.0;
  double place_m = 2.0;
  double idle_rounds = 2.0;
  RoleSettings roles;
  ExchangeSettings exchange;
  RoundSettings rounds;
  map::ExploreSettings explore;
  map::FrontierSettings frontiers;
  FleetSettings fleet;

  template <class V>
  void visit(V& v) {
    v("status_s", status_s, 0.1, 60.0, "between two statuses [s]");
    v("estimate_s", estimate_s, 1.0, 600.0, "least time between estimates of the anchor [s]");
    v("estimate_fraction", estimate_fraction, 0.0, 1.0,
      "likewise, as a fraction of the mission's age");
    v("frontier_period_s", look_s, 0.5, 60.0, "time between two searches for frontiers [s]");
    v("shift_m", moved_m, 0.0, 10.0, "keyframes with a larger correction are sent again [m]");
    v("moving_after_s", rest_s, 0.0, 60.0,
      "time without standstill after which a vehicle is moving [s]");
    v("arrive_m", arrive_m, 0.1, 20.0, "distance to the goal at standstill that is an arrival [m]");
    v("taken_m", taken_m, 0.0, 50.0, "frontiers nearer than this to a goal are taken [m]");
    v("choice_wait_s", choice_wait_s, 0.0, 600.0, "for the best next anchor to have all facts [s]");
    v("back_m", back_m, 0.0, 50.0, "driven back where ranges were lost [m]");
    v("lost_s", lost_s, 1.0, 3600.0,
      "time without messages after which a vehicle is not waited for [s]");
    v("progress_m", place_m, 0.1, 50.0, "progress is a keyframe this far from all before [m]");
    v("idle_rounds", idle_rounds, 1.0, 100.0,
      "rounds without progress that end the mission, times the vehicles");
    v.group("roles", roles, "who is anchor");
    v.group("exchange", exchange, "how facts are passed on");
    v.group("rounds", rounds, "rounds and goals");
    v.group("explore", explore, "grid in which frontiers are searched");
    v.group("frontiers", frontiers, "what counts as a frontier");
  }
};

}  // namespace rali::fleet
