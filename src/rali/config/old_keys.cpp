#include "rali/config/old_keys.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace rali::config {
namespace {

struct Renamed {
  std::string_view old_key, key;
};

/// Groups and keys below `settings.` as version 0.1 had them. A key of a renamed group that is not
/// listed keeps its name within it.
constexpr std::array kRenamed{
    Renamed{"fleet.boundary", "fleet.separator_prior"},
    Renamed{"fleet.boundary.moved_sigma", "fleet.separator_prior.shift_sigma"},
    Renamed{"fleet.boundary.moved_m", "fleet.separator_prior.shift_m"},
    Renamed{"fleet.init.search.stand_m", "fleet.init.search.standstill_m"},
    Renamed{"fleet.init.track.still_m", "fleet.init.track.standstill_m"},
    Renamed{"fleet.joint.sight", "fleet.joint.line_of_sight"},
    Renamed{"fleet.joint.stretch_sd", "fleet.joint.common_error_sd"},
    Renamed{"fleet.loops.blind_tries", "fleet.loops.unguided_tries"},
    Renamed{"fleet.places.recognise.facing_share", "fleet.places.recognise.facing_fraction"},
    Renamed{"fleet.places.recognise.search.least_share",
            "fleet.places.recognise.search.min_fraction"},
    Renamed{"fleet.places.recognise.search.ridge_share",
            "fleet.places.recognise.search.ridge_fraction"},
    Renamed{"map.dynamic.look_share_max", "map.dynamic.through_fraction_max"},
    Renamed{"map.dynamic.pass_share", "map.dynamic.pass_fraction"},
    Renamed{"map.dynamic.plane_share_max", "map.dynamic.plane_fraction_max"},
    Renamed{"map.grid.hit_share", "map.grid.hit_fraction"},
    Renamed{"mission.estimate_share", "mission.estimate_fraction"},
    Renamed{"mission.look_s", "mission.frontier_period_s"},
    Renamed{"mission.moved_m", "mission.shift_m"},
    Renamed{"mission.rest_s", "mission.moving_after_s"},
    Renamed{"mission.place_m", "mission.progress_m"},
    Renamed{"mission.exchange.goodput_share", "mission.exchange.goodput_fraction"},
    Renamed{"mission.exchange.heard_s", "mission.exchange.link_timeout_s"},
    Renamed{"mission.roles.stand_s", "mission.roles.standstill_s"},
    Renamed{"mission.rounds.stand_min_s", "mission.rounds.standstill_min_s"},
    Renamed{"odometry.paper.registration_share", "odometry.paper.registration_fraction"},
    Renamed{"odometry.robust.initialisation.rest", "odometry.robust.initialisation.standstill"},
    Renamed{"odometry.robust.initialisation.rest_travel_max_m",
            "odometry.robust.initialisation.standstill_travel_max_m"},
    Renamed{"odometry.robust.initialisation.still_accel_sd_max_mps2",
            "odometry.robust.initialisation.standstill_accel_sd_max_mps2"},
    Renamed{"odometry.robust.initialisation.still_speed_sigma_mps",
            "odometry.robust.initialisation.standstill_speed_sigma_mps"},
    Renamed{"odometry.robust.constraints.rest_after_s",
            "odometry.robust.constraints.standstill_after_s"},
    Renamed{"ranging.excess.doubt_factor", "ranging.excess.uncertainty_factor"},
    Renamed{"ranging.excess.end_share", "ranging.excess.end_fraction"},
    Renamed{"ranging.finder", "ranging.initialisation"},
    Renamed{"ranging.finder.tell_sigmas", "ranging.initialisation.report_sigmas"},
    Renamed{"ranging.link.suspect_share", "ranging.link.suspect_fraction"},
    Renamed{"ranging.link.widen_most", "ranging.link.widen_max"},
    Renamed{"ranging.mixture.doubt_m", "ranging.mixture.uncertain_m"},
    Renamed{"ranging.mixture.wild_share", "ranging.mixture.outlier_fraction"},
    Renamed{"ranging.mixture.wild_sigma_m", "ranging.mixture.outlier_sigma_m"},
    Renamed{"ranging.paper.share", "ranging.paper.corrected"},
    Renamed{"ranging.place_lost_s", "ranging.landmark_lost_s"},
    Renamed{"ranging.place_stay_m", "ranging.landmark_stay_m"},
    Renamed{"ranging.place_silent_s", "ranging.landmark_silent_s"},
    Renamed{"ranging.sight", "ranging.line_of_sight"},
    Renamed{"vehicle.back_end.blind_min_m", "vehicle.back_end.degenerate_min_m"},
    Renamed{"vehicle.back_end.graph.window_blind_s", "vehicle.back_end.graph.window_degenerate_s"},
    Renamed{"vehicle.path.rest_s", "vehicle.path.standstill_s"},
};

struct Removed {
  std::string_view key, reason;
};

constexpr std::string_view kRangeNoise =
    "The noise of ranges is measured; settings.odometry.robust.range_sigma_m overrides it";
constexpr std::string_view kNoLimit = "It has no effect any more";

constexpr std::array kRemoved{
    Removed{"mission.rounds.finish.unreachable_max", kNoLimit},
    Removed{"mission.stuck_s", kNoLimit},
    Removed{"odometry.robust.initialisation.accel_bias_bound_mps2",
            "settings.odometry.robust.initialisation.accel_bias_sigma_mps2 bounds the bias"},
    Removed{"odometry.robust.initialisation.gyro_bias_bound_radps",
            "settings.odometry.robust.initialisation.gyro_bias_sigma_radps bounds the bias"},
    Removed{"odometry.robust.map.plane.range_sigma_m", kRangeNoise},
    Removed{"odometry.robust.match.range_sigma_m", kRangeNoise},
};

/// Today's name of a key or group.
std::string current_key(std::string_view key) {
  std::string_view group, renamed_group;
  for (const Renamed& entry : kRenamed) {
    if (entry.old_key == key) return std::string(entry.key);
    const bool within = key.starts_with(entry.old_key) && key[entry.old_key.size()] == '.';
    if (!within || entry.old_key.size() <= group.size()) continue;
    group = entry.old_key;
    renamed_group = entry.key;
  }
  return std::string(renamed_group) + std::string(key.substr(group.size()));
}

const Removed* removed_key(std::string_view key) {
  const auto* const at = std::find_if(kRemoved.begin(), kRemoved.end(),
                                      [&](const Removed& r) { return r.key == key; });
  return at == kRemoved.end() ? nullptr : at;
}

struct Moved {
  std::string key;
  Node value;
};

/// Takes the values with an old name out of the tree; groups that become empty go too.
class OldKeys {
 public:
  OldKeys(std::vector<Moved>& moved, std::vector<std::string>& notices)
      : moved_(moved), notices_(notices) {}

  void take(Node& group, const std::string& prefix) {
    std::vector<Node> kept;
    for (Node& child : group.children) {
      const std::string key = prefix + child.key;
      const bool was_group = child.kind == Node::Kind::kMap && !child.children.empty();
      if (was_group) take(child, key + '.');
      if (was_group ? child.children.empty() : is_old(child, key)) continue;
      kept.push_back(std::move(child));
    }
    group.children = std::move(kept);
  }

 private:
  bool is_old(Node& value, const std::string& key) {
    if (const Removed* const removed = removed_key(key); removed != nullptr) {
      notices_.push_back(fmt::format("{}: settings.{} was removed and is ignored. {}",
                                     value.key_where, key, removed->reason));
      return true;
    }
    std::string now = current_key(key);
    if (now == key) return false;
    notices_.push_back(
        fmt::format("{}: settings.{} is called settings.{} now. The old name is read in this "
                    "release only",
                    value.key_where, key, now));
    moved_.push_back({std::move(now), std::move(value)});
    return true;
  }

  std::vector<Moved>& moved_;
  std::vector<std::string>& notices_;
};

/// Puts a value at its place below `group`, unless one is there.
void put(Node& group, std::string_view key, Node value) {
  Node* at = &group;
  for (std::size_t dot = key.find('.'); dot != std::string_view::npos; dot = key.find('.')) {
    const std::string_view name = key.substr(0, dot);
    auto child = std::find_if(at->children.begin(), at->children.end(),
                              [&](const Node& node) { return node.key == name; });
    if (child == at->children.end()) {
      Node made;
      made.kind = Node::Kind::kMap;
      made.key = std::string(name);
      made.key_where = made.where = value.where;
      at->children.push_back(std::move(made));
      child = at->children.end() - 1;
    }
    at = &*child;
    key.remove_prefix(dot + 1);
  }
  // Something else in the place of a group is reported when the keys are applied.
  if (at->kind != Node::Kind::kMap || at->find(key) != nullptr) return;
  value.key = std::string(key);
  at->children.push_back(std::move(value));
}

void rename_below(Node& settings, std::vector<std::string>& notices) {
  std::vector<Moved> moved;
  OldKeys(moved, notices).take(settings, "");
  for (Moved& one : moved) put(settings, one.key, std::move(one.value));
}

}  // namespace

Node with_current_keys(Node root, std::vector<std::string>& notices) {
  for (Node& child : root.children) {
    if (child.key == "settings" && child.kind == Node::Kind::kMap) rename_below(child, notices);
  }
  return root;
}

Node assignment_with_current_keys(Node root, std::vector<std::string>& notices) {
  const bool full = root.find("settings") != nullptr;
  if (full) return with_current_keys(std::move(root), notices);
  rename_below(root, notices);
  return root;
}

}  // namespace rali::config
