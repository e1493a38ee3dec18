#include "rali/config/old_keys.hpp"

#include <array>
#include <string_view>
#include <utility>

#include "rali/config/key_changes.hpp"

namespace rali::config {
namespace {

/// Groups and keys below `settings.` as version 0.1 had them. A key of a renamed group that is not
/// listed keeps its name within it.
constexpr std::array kRenamed{
    RenamedKey{"fleet.boundary", "fleet.separator_prior"},
    RenamedKey{"fleet.boundary.moved_sigma", "fleet.separator_prior.shift_sigma"},
    RenamedKey{"fleet.boundary.moved_m", "fleet.separator_prior.shift_m"},
    RenamedKey{"fleet.init.search.stand_m", "fleet.init.search.standstill_m"},
    RenamedKey{"fleet.init.track.still_m", "fleet.init.track.standstill_m"},
    RenamedKey{"fleet.joint.sight", "fleet.joint.line_of_sight"},
    RenamedKey{"fleet.joint.stretch_sd", "fleet.joint.common_error_sd"},
    RenamedKey{"fleet.loops.blind_tries", "fleet.loops.unguided_tries"},
    RenamedKey{"fleet.places.recognise.facing_share", "fleet.places.recognise.facing_fraction"},
    RenamedKey{"fleet.places.recognise.search.least_share",
               "fleet.places.recognise.search.min_fraction"},
    RenamedKey{"fleet.places.recognise.search.ridge_share",
               "fleet.places.recognise.search.ridge_fraction"},
    RenamedKey{"map.dynamic.look_share_max", "map.dynamic.through_fraction_max"},
    RenamedKey{"map.dynamic.pass_share", "map.dynamic.pass_fraction"},
    RenamedKey{"map.dynamic.plane_share_max", "map.dynamic.plane_fraction_max"},
    RenamedKey{"map.grid.hit_share", "map.grid.hit_fraction"},
    RenamedKey{"mission.estimate_share", "mission.estimate_fraction"},
    RenamedKey{"mission.look_s", "mission.frontier_period_s"},
    RenamedKey{"mission.moved_m", "mission.shift_m"},
    RenamedKey{"mission.rest_s", "mission.moving_after_s"},
    RenamedKey{"mission.place_m", "mission.progress_m"},
    RenamedKey{"mission.exchange.goodput_share", "mission.exchange.goodput_fraction"},
    RenamedKey{"mission.exchange.heard_s", "mission.exchange.link_timeout_s"},
    RenamedKey{"mission.roles.stand_s", "mission.roles.standstill_s"},
    RenamedKey{"mission.rounds.stand_min_s", "mission.rounds.standstill_min_s"},
    RenamedKey{"odometry.paper.registration_share", "odometry.paper.registration_fraction"},
    RenamedKey{"odometry.robust.initialisation.rest", "odometry.robust.initialisation.standstill"},
    RenamedKey{"odometry.robust.initialisation.rest_travel_max_m",
               "odometry.robust.initialisation.standstill_travel_max_m"},
    RenamedKey{"odometry.robust.initialisation.still_accel_sd_max_mps2",
               "odometry.robust.initialisation.standstill_accel_sd_max_mps2"},
    RenamedKey{"odometry.robust.initialisation.still_speed_sigma_mps",
               "odometry.robust.initialisation.standstill_speed_sigma_mps"},
    RenamedKey{"odometry.robust.constraints.rest_after_s",
               "odometry.robust.constraints.standstill_after_s"},
    RenamedKey{"ranging.excess.end_share", "ranging.excess.end_fraction"},
    RenamedKey{"ranging.finder", "ranging.initialisation"},
    RenamedKey{"ranging.finder.tell_sigmas", "ranging.initialisation.report_sigmas"},
    RenamedKey{"ranging.link.suspect_share", "ranging.link.suspect_fraction"},
    RenamedKey{"ranging.link.widen_most", "ranging.link.widen_max"},
    RenamedKey{"ranging.mixture.doubt_m", "ranging.mixture.uncertain_m"},
    RenamedKey{"ranging.mixture.wild_share", "ranging.mixture.outlier_fraction"},
    RenamedKey{"ranging.mixture.wild_sigma_m", "ranging.mixture.outlier_sigma_m"},
    RenamedKey{"ranging.paper.share", "ranging.paper.corrected"},
    RenamedKey{"ranging.place_lost_s", "ranging.landmark_lost_s"},
    RenamedKey{"ranging.place_stay_m", "ranging.landmark_stay_m"},
    RenamedKey{"ranging.place_silent_s", "ranging.landmark_silent_s"},
    RenamedKey{"ranging.sight", "ranging.line_of_sight"},
    RenamedKey{"vehicle.path.rest_s", "vehicle.path.standstill_s"},
};

constexpr std::string_view kRangeNoise =
    "The noise of ranges is measured; settings.odometry.robust.range_sigma_m overrides it";
constexpr std::string_view kExcess =
    "An excess ends with a step down, however uncertain the pose has become";
constexpr std::string_view kNoLimit = "It has no effect any more";

constexpr std::array kRemoved{
    RemovedKey{"fleet.init.scan2map.noise_factor", kNoLimit},
    RemovedKey{"fleet.init.scan2map.overlap_min", kNoLimit},
    RemovedKey{"fleet.init.watch", kNoLimit},
    RemovedKey{"mission.rounds.finish.unreachable_max", kNoLimit},
    RemovedKey{"mission.stuck_s", kNoLimit},
    RemovedKey{"odometry.robust.drift.tilt_sigma_degpm",
               "It follows from the lasers' errors, which are measured; "
               "until then settings.odometry.robust.drift.laser_sigma_deg is used"},
    RemovedKey{"odometry.robust.initialisation.accel_bias_bound_mps2",
               "settings.odometry.robust.initialisation.accel_bias_sigma_mps2 bounds the bias"},
    RemovedKey{"odometry.robust.initialisation.gyro_bias_bound_radps",
               "settings.odometry.robust.initialisation.gyro_bias_sigma_radps bounds the bias"},
    RemovedKey{"odometry.robust.map.plane.range_sigma_m", kRangeNoise},
    RemovedKey{"odometry.robust.match.range_sigma_m", kRangeNoise},
    RemovedKey{"odometry.robust.update.tilt_sigma_rad", kNoLimit},
    RemovedKey{"ranging.excess.doubt_factor", kExcess},
    RemovedKey{"ranging.excess.gap_s", "settings.ranging.excess.memory_s bounds the comparison"},
    RemovedKey{"ranging.excess.uncertainty_factor", kExcess},
    RemovedKey{"vehicle.back_end",
               "Vehicles that are joined have one graph; others keep the path "
               "of their odometry"},
};

constexpr KeyChanges kChanges{kRenamed, kRemoved, "settings."};

}  // namespace

Node with_current_keys(Node root, std::vector<std::string>& notices) {
  for (Node& child : root.children) {
    if (child.key == "settings" && child.kind == Node::Kind::kMap)
      apply_key_changes(kChanges, child, notices);
  }
  return root;
}

Node assignment_with_current_keys(Node root, std::vector<std::string>& notices) {
  const bool full = root.find("settings") != nullptr;
  if (full) return with_current_keys(std::move(root), notices);
  apply_key_changes(kChanges, root, notices);
  return root;
}

}  // namespace rali::config
