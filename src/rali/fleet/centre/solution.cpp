#include "rali/fleet/centre/solution.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "rali/fleet/centre/frame_search.hpp"
#include "rali/fleet/centre/group_estimate.hpp"
#include "rali/fleet/centre/scan_evidence.hpp"
#include "rali/fleet/centre/sight_lines.hpp"
#include "rali/fleet/centre/upright.hpp"

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

/// As they were when the earlier rounds ended: all in one group.
PathFrames at_boundary(std::span<const VehiclePath> paths, const RoundBoundary& boundary) {
  PathFrames frames = apart(paths);
  frames.groups.assign(1, {});
  for (std::size_t i = 0; i < paths.size(); ++i) {
    frames.groups[0].push_back(i);
    frames.group[i] = 0;
    for (const BoundaryPath& known : boundary.paths) {
      if (known.stream != stream_of(paths[i])) continue;
      const auto node = paths[i].index_of(known.node);
      if (!node) continue;
      frames.T_map_odom[i] = known.T_map_body * paths[i].nodes()[*node].step.T_odom_body.inverse();
    }
  }
  return frames;
}

/// Puts the pieces whose middle is before the boundary first. @return how many
std::size_t finished_first(std::vector<PathSubmap>& pieces, std::span<const VehiclePath> paths,
                           const RoundBoundary* before) {
  if (before == nullptr) return 0;
  const std::vector<std::size_t> begins = begins_of(paths, before);
  const auto live = std::stable_partition(
      pieces.begin(), pieces.end(), [&](const PathSubmap& p) { return p.node < begins[p.path]; });
  return static_cast<std::size_t>(live - pieces.begin());
}

/// The comparisons that the frames rest on belong to the graph, too: one of start poses and ranges
/// alone lies elsewhere, is sure of it, and refuses the same comparison as outside of its guess.
std::vector<LoopFound> agreeing(std::span<const VehiclePath> paths, const Solution& solution,
                                std::vector<LoopFound> seen, const InitSettings& settings) {
  std::erase_if(seen, [&](const LoopFound& found) {
    return !agrees(paths, solution.pieces, found, solution.frames, settings);
  });
  return seen;
}

/// Says of all who are in no group with the reference what is missing.
void tell_who_waits(std::span<const VehiclePath> paths, const FrameSolver& solver, Solution& out) {
  VehicleNames names;
  for (const VehiclePath& path : paths) names[path.vehicle()] = path.name();
  // What the solver says is how somebody stands to the reference; if that is not in the map, it is
  // the map's own vehicle that waits for it.
  const std::size_t reference = out.estimate.frames[0].group;
  const std::size_t of_map = out.frames.groups[0].front();
  for (std::size_t i = 0; i < paths.size(); ++i) {
    VehicleFrame& frame = out.estimate.frames[i];
    if (frame.group == 0) continue;
    const std::size_t who = frame.group == reference ? of_map : i;
    frame.waits_for = solver.text(stream_of(paths[who]), names);
  }
}

}  // namespace

Solution solve_fleet(SolutionInput in, Executor& executor) {
  Solution out;
  if (in.paths.empty()) return out;
  std::vector<VehiclePath> upright_paths;
  if (in.settings.join && in.paths.size() > 1 && in.settings.solve == SolveWhat::kAll) {
    upright_paths = upright(in.paths, in.settings.cut, in.settings.places, executor);
  }
  const std::span<const VehiclePath> paths = upright_paths.empty() ? in.paths : upright_paths;
  JointRanges ranges;
  if (in.knowledge.common_clock) {
    const Duration warm_up = Duration::from_s(in.settings.boundary.warm_up_s);
    ranges = join_ranges(
        paths, in.before != nullptr ? std::optional(in.before->until - warm_up) : std::nullopt);
  }
  const std::vector<StartPrior> starts = priors_of(paths, in.knowledge.starts);
  out.pieces = std::move(in.pieces);
  std::vector<PathSubmap> cut =
      cut_into_submaps(paths, in.settings.cut, in.settings.places, executor, in.cut_from);
  std::move(cut.begin(), cut.end(), std::back_inserter(out.pieces));
  std::optional<FrameSolver> solver;
  std::vector<LoopFound> seen;
  if (in.before != nullptr) {
    out.frames = at_boundary(paths, *in.before);
  } else if (in.frames) {
    out.frames = std::move(*in.frames);
  } else if (in.settings.join && paths.size() > 1) {
    FoundFrames found = find_frames(paths, out.pieces, ranges, starts, in.settings, executor);
    solver = std::move(found.solver);
    out.frames = frames_of(paths, solver->frames());
    seen = agreeing(paths, out, std::move(found.seen), in.settings.init);
    if (in.memory != nullptr) in.memory->of_frames.clear();
  } else {
    out.frames = apart(paths);
  }
  // Pieces of earlier rounds are compared with by who knows where they lie.
  out.live_from = finished_first(out.pieces, paths, in.before);
  const std::span<const PathSubmap> pieces(out.pieces);
  if (in.settings.joint.sight) {
    doubt_through_walls(pieces, out.frames, in.settings.ranging, ranges);
  }
  const GroupInput group{paths,       pieces.subspan(out.live_from),
                         out.frames,  ranges,
                         starts,      biases_of(paths, ranges, in.knowledge.biases),
                         in.settings, seen,
                         in.before,   in.memory};
  for (std::size_t g = 0; g < out.frames.groups.size(); ++g) {
    auto boundaries =
        estimate_group(group, g, executor, out.estimate,
                       g == 0 ? std::span<const Time>(in.ends) : std::span<const Time>());
    if (g == 0) out.boundaries = std::move(boundaries);
  }
  if (solver) tell_who_waits(paths, *solver, out);
  return out;
}

}  // namespace rali::fleet
