#include "rounds.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "truth.hpp"

namespace rali::fleet_bench {

namespace {

using geometry::SE3;

/// Aligns ground truth to the first keyframe of the map's first vehicle: errors grow from there.
std::optional<SE3> T_map_world(const Mission& mission, const fleet::FleetEstimate& estimate) {
  if (estimate.groups.empty() || estimate.groups[0].empty()) return std::nullopt;
  const auto first = estimate.keyframes.lower_bound({estimate.groups[0].front(), 0});
  if (first == estimate.keyframes.end()) return std::nullopt;
  const auto truth = truth_at(mission, first->first.vehicle, first->second.t);
  if (!truth) return std::nullopt;
  return first->second.T_map_body * truth->inverse();
}

struct At {
  double path_m = 0.0;  ///< of the vehicle that is farthest from its start
  double worst_m = 0.0, sigma_m = 0.0;
};

/// Errors of the newest keyframe of each vehicle up to a time.
std::optional<At> errors_at(const Mission& mission, const fleet::FleetEstimate& estimate, Time t) {
  const auto T = T_map_world(mission, estimate);
  if (!T) return std::nullopt;
  At at;
  for (const VehicleId vehicle : estimate.groups[0]) {
    const fleet::KeyframePose* newest = nullptr;
    for (auto k = estimate.keyframes.lower_bound({vehicle, 0});
         k != estimate.keyframes.end() && k->first.vehicle == vehicle && k->second.t <= t; ++k) {
      newest = &k->second;
    }
    if (newest == nullptr) continue;
    const auto truth = truth_at(mission, vehicle, newest->t);
    if (!truth) continue;
    const SE3& begin = mission.vehicles[vehicle.value].T_world_start;
    at.path_m = std::max(at.path_m, (truth->p - begin.p).norm());
    const double error_m = (newest->T_map_body.p - *T * truth->p).norm();
    if (error_m < at.worst_m) continue;
    at.worst_m = error_m;
    at.sigma_m = std::sqrt(std::max(0.0, newest->covariance.bottomRightCorner<3, 3>().trace()));
  }
  return at;
}

}  // namespace

std::string round_table(const Mission& mission, const Joined& joined) {
  std::string text =
      "| round | way m | worst error then m | sigma m | at the end m | centre s | nodes | prior | "
      "solved |\n|---|---|---|---|---|---|---|---|---|\n";
  for (std::size_t k = 0; k < joined.rounds.size(); ++k) {
    const RoundMark& round = joined.rounds[k];
    const auto then = errors_at(mission, round.estimate, round.end);
    const auto late = errors_at(mission, joined.estimate, round.end);
    if (!then || !late) continue;
    text +=
        fmt::format("| {} | {:.0f} | {:.3f} | {:.3f} | {:.3f} | {:.2f} | {} | {} | {} |\n", k + 1,
                    then->path_m, then->worst_m, then->sigma_m, late->worst_m, round.cpu_ms * 1e-3,
                    round.nodes, round.unknowns, round.whole ? "all" : "round");
  }
  return text;
}

}  // namespace rali::fleet_bench
