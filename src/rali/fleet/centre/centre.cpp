#include "rali/fleet/centre/centre.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "rali/fleet/centre/frame_search.hpp"
#include "rali/fleet/centre/group_estimate.hpp"
#include "rali/fleet/centre/path_frames.hpp"

namespace rali::fleet {

namespace {

std::size_t index_of(std::span<const VehiclePath> paths, VehicleId vehicle) {
  std::size_t i = 0;
  while (i < paths.size() && paths[i].vehicle() != vehicle) ++i;
  return i;
}

/// What is known of vehicles, for those that have a path.
std::vector<StartPrior> priors_of(std::span<const VehiclePath> paths,
                                  const std::vector<GivenStart>& starts) {
  std::vector<StartPrior> priors;
  for (const GivenStart& start : starts) {
    const std::size_t relative_to = index_of(paths, start.relative_to);
    const std::size_t path = index_of(paths, start.vehicle);
    if (relative_to >= paths.size() || path >= paths.size()) continue;
    priors.push_back({relative_to, path, start.T_relative_vehicle, start.sigma_m, start.sigma_rad});
  }
  return priors;
}

std::vector<std::optional<double>> biases_of(std::span<const VehiclePath> paths,
                                             const JointRanges& ranges,
                                             const std::vector<GivenBias>& given) {
  std::vector<std::optional<double>> biases;
  for (const AntennaPair& pair : ranges.pairs) {
    const VehicleId a = paths[pair.a.path].vehicle(), b = paths[pair.b.path].vehicle();
    const auto known = std::find_if(given.begin(), given.end(), [&](const GivenBias& g) {
      return std::minmax(g.a, g.b) == std::minmax(a, b);
    });
    biases.push_back(known == given.end() ? std::nullopt : std::optional(known->bias_m));
  }
  return biases;
}

/// Every vehicle for itself.
PathFrames apart(std::span<const VehiclePath> paths) {
  PathFrames frames;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    frames.groups.push_back({i});
    frames.group.push_back(i);
    frames.T_map_odom.push_back(T_map_odom_alone(paths[i]));
    frames.decided_by.emplace_back();
  }
  return frames;
}

}  // namespace

Centre::Centre(const FleetSettings& settings, FleetKnowledge knowledge)
    : settings_(settings), knowledge_(std::move(knowledge)) {}

void Centre::add(const Fact& fact) {
  const auto key_of = [](const VehiclePath& p) { return std::tuple(p.vehicle(), p.epoch()); };
  const std::tuple key(fact.key.vehicle, fact.key.epoch);
  auto path = std::lower_bound(paths_.begin(), paths_.end(), key,
                               [&](const VehiclePath& p, const auto& k) { return key_of(p) < k; });
  if (path == paths_.end() || key_of(*path) != key) {
    path = paths_.insert(path, VehiclePath(fact.key.vehicle, fact.key.epoch));
  }
  path->add(fact.t, fact.body);
}

FleetEstimate Centre::estimate(Executor& executor) const {
  std::vector<VehiclePath> paths;
  for (const VehiclePath& path : paths_) {
    if (!path.nodes().empty()) paths.push_back(path);
  }
  FleetEstimate out;
  if (paths.empty()) return out;
  JointRanges ranges;
  if (knowledge_.common_clock) ranges = join_ranges(paths);
  const std::vector<StartPrior> starts = priors_of(paths, knowledge_.starts);
  const std::vector<PathSubmap> submaps =
      cut_into_submaps(paths, settings_.cut, settings_.places, executor);
  PathFrames frames = apart(paths);
  VehicleNames names;
  for (const VehiclePath& path : paths) names[path.vehicle()] = path.name();
  std::optional<FrameSolver> solver;
  if (settings_.join && paths.size() > 1) {
    solver = find_frames(paths, submaps, ranges, starts, settings_, executor);
    frames = frames_of(paths, *solver);
  }
  const GroupInput input{paths,    submaps, frames,
                         ranges,   starts,  biases_of(paths, ranges, knowledge_.biases),
                         settings_};
  for (std::size_t g = 0; g < frames.groups.size(); ++g) estimate_group(input, g, executor, out);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    VehicleFrame& frame = out.frames[i];
    if (frame.group > 0 && solver) frame.waits_for = solver->text(stream_of(paths[i]), names);
  }
  return out;
}

}  // namespace rali::fleet
