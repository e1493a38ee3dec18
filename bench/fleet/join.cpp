#include "join.hpp"

#include <fmt/format.h>

#include "common/cpu_time.hpp"
#include "common/vehicle_settings.hpp"
#include "rali/drive/fleet_rounds.hpp"
#include "rali/drive/output/joint_path.hpp"
#include "rali/vehicle/settings.hpp"
#include "rali/wire/fleet/codec.hpp"
#include "starts.hpp"

namespace rali::fleet_bench {

using geometry::SE3;

namespace {

Path path_of(const Driven& driven, const fleet::FleetEstimate& estimate, VehicleId vehicle) {
  Path path;
  path.poses = driven.poses;
  path.keyframes = driven.keyframes;
  const drive::JointPath joint = drive::joint_path(estimate, vehicle);
  path.T_map_odom = joint.T_map_local;
  drive::correct_path(joint.keyframes.empty() ? driven.smoothed : joint.keyframes, path.poses,
                      path.keyframes);
  return path;
}

}  // namespace

Result<Joined> join(const Mission& mission, std::uint64_t seed, const JoinOptions& options) {
  const auto settings = bench::fleet_settings(options.settings);
  if (!settings) return tl::make_unexpected(settings.error());
  fleet::FleetKnowledge knowledge;
  if (options.starts) {
    std::vector<SE3> T_world_start;
    for (const Driven& driven : mission.vehicles) T_world_start.push_back(driven.T_world_start);
    knowledge.starts = starts_by_hand(T_world_start, seed);
  }
  knowledge.common_clock = options.common_clock;
  fleet::RoundCentre centre(*settings, knowledge);
  std::vector<std::vector<std::shared_ptr<const fleet::Fact>>> facts;
  std::vector<drive::ReportedByVehicle> reported;
  for (const Driven& driven : mission.vehicles) {
    facts.emplace_back();
    for (const wire::Bytes& bytes : driven.facts) {
      const auto envelope = wire::decode_envelope(bytes);
      if (!envelope) return tl::make_unexpected(envelope.error());
      facts.back().push_back(std::get<fleet::FactMessage>(envelope->message).fact);
    }
  }
  for (std::size_t v = 0; v < facts.size(); ++v) {
    if (mission.vehicles[v].poses.empty()) continue;
    reported.push_back({VehicleId{static_cast<std::uint16_t>(v)}, facts[v],
                        mission.vehicles[v].poses.back().t, vehicle::PathSettings{}.rest_s});
  }
  Joined joined;
  SerialExecutor executor;
  std::vector<Time> ends;
  const bool rounds = options.by_rounds || settings->solve == fleet::SolveWhat::kRounds;
  if (rounds) ends = drive::round_ends(reported, drive::RoundsJob{});
  const double begin = bench::cpu_ms();
  double last = begin;
  std::size_t wholes = 0, solved = 0;
  joined.estimate = drive::estimate_by_rounds(reported, ends, centre, executor, [&](Time end) {
    const double now = bench::cpu_ms();
    const auto& separator = centre.separator();
    joined.rounds.push_back({end, centre.last(), now - last, centre.work().nodes,
                             separator ? static_cast<std::size_t>(separator->unknowns()) : 0,
                             centre.work().whole > wholes});
    // Progress output, because long missions take time.
    fmt::print(stderr, "round {} of {}: {:.2f} s, {} nodes, solved {} times, {} pieces known\n",
               joined.rounds.size(), ends.size(), joined.rounds.back().cpu_ms * 1e-3,
               joined.rounds.back().nodes, centre.work().rounds - solved, centre.work().pieces);
    solved = centre.work().rounds;
    wholes = centre.work().whole;
    last = bench::cpu_ms();
  });
  joined.cpu_ms = bench::cpu_ms() - begin;
  for (std::size_t v = 0; v < mission.vehicles.size(); ++v) {
    joined.paths.push_back(
        path_of(mission.vehicles[v], joined.estimate, VehicleId{static_cast<std::uint16_t>(v)}));
  }
  return joined;
}

}  // namespace rali::fleet_bench
