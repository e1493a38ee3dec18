#include "rali/fleet/centre/solution.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "rali/fleet/centre/frame_search.hpp"
#include "rali/fleet/centre/group_estimate.hpp"
#include "rali/fleet/centre/refused_loops.hpp"
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

/// The start poses between vehicles that have a path.
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

/// Every vehicle as a group of its own.
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

/// Frames at the end of the earlier rounds: all in one group.
PathFrames at_separator(std::span<const VehiclePath> paths, const SeparatorPrior& separator) {
  PathFrames frames = apart(paths);
  frames.groups.assign(1, {});
  for (std::size_t i = 0; i < paths.size(); ++i) {
    frames.groups[0].push_back(i);
    frames.group[i] = 0;
    for (const SeparatorPath& known : separator.paths) {
      if (known.stream != stream_of(paths[i])) continue;
      const auto node = paths[i].index_of(known.node);
      if (!node) continue;
      frames.T_map_odom[i] = known.T_map_body * paths[i].nodes()[*node].step->T_odom_body.inverse();
    }
  }
  return frames;
}

/// Puts the pieces whose middle is before the separator first. @return how many
std::size_t finished_first(std::vector<PathSubmap>& pieces, std::span<const VehiclePath> paths,
                           const SeparatorPrior* before) {
  if (before == nullptr) return 0;
  const std::vector<std::size_t> begins = begins_of(paths, before);
  const auto live = std::stable_partition(
      pieces.begin(), pieces.end(), [&](const PathSubmap& p) { return p.node < begins[p.path]; });
  return static_cast<std::size_t>(live - pieces.begin());
}

/// Comparisons that determined the frames belong to the graph, too. A graph of start poses and
/// ranges alone has another pose with a small sigma, and rejects the same comparison as outside of
/// its guess.
std::vector<Loop> agreeing(std::span<const VehiclePath> paths, const Solution& solution,
                           std::span<const LoopFound> seen, const FleetSettings& settings) {
  std::vector<Loop> out;
  for (const LoopFound& found : seen) {
    if (!agrees(paths, solution.pieces, found, solution.frames, settings.init)) continue;
    out.push_back(loop_of(solution.pieces, found, settings.loops.bend_per_m));
  }
  return out;
}

/// A solution in progress.
class FleetSolve {
 public:
  FleetSolve(SolutionInput& in, std::span<const VehiclePath> paths, Executor& executor)
      : in_(in),
        paths_(paths),
        executor_(executor),
        starts_(priors_of(paths, in.knowledge.starts)) {}

  Solution run() {
    const std::size_t before = in_.memory != nullptr ? in_.memory->compared.size() : 0;
    gather();
    if (!in_.stop.raised()) look_for_frames();
    if (!in_.stop.raised()) estimate();
    if (!in_.stop.raised() && found_ && frames_rejected()) estimate();
    if (!in_.stop.raised() && found_) report_contradicted_starts();
    if (!in_.stop.raised() && found_) report_who_waits();
    if (in_.memory != nullptr) out_.compared += in_.memory->compared.size() - before;
    return std::move(out_);
  }

 private:
  void gather();
  void look_for_frames();
  void take_frames(const FrameSolver& solver);
  void estimate();
  bool frames_rejected();
  void report_contradicted_starts();
  void report_who_waits();

  SolutionInput& in_;
  std::span<const VehiclePath> paths_;
  Executor& executor_;
  std::vector<StartPrior> starts_;
  JointRanges ranges_;
  std::optional<FoundFrames> found_;  ///< if frames were searched
  std::vector<Loop> seen_;            ///< comparisons that agree with the frames
  Solution out_;
};

void FleetSolve::gather() {
  if (in_.knowledge.common_clock) {
    const Duration warm_up = Duration::from_s(in_.settings.separator.warm_up_s);
    ranges_ = join_ranges(
        paths_, in_.before != nullptr ? std::optional(in_.before->until - warm_up) : std::nullopt);
  }
  out_.pieces = std::move(in_.pieces);
  std::vector<PathSubmap> cut = cut_into_submaps(paths_, in_.settings.cut, in_.settings.places,
                                                 executor_, in_.cut_from, in_.stop);
  if (in_.stop.raised()) return;
  out_.cut = cut.size();
  std::move(cut.begin(), cut.end(), std::back_inserter(out_.pieces));
}

void FleetSolve::look_for_frames() {
  if (in_.before != nullptr) {
    out_.frames = at_separator(paths_, *in_.before);
  } else if (in_.frames) {
    out_.frames = std::move(*in_.frames);
  } else if (in_.settings.join && paths_.size() > 1) {
    found_ = find_frames(paths_, out_.pieces, ranges_, starts_, in_.settings, executor_,
                         in_.compared, in_.stop);
    out_.compared = found_->compared;
    take_frames(found_->solver);
  } else {
    out_.frames = apart(paths_);
  }
  // The caller, which has their poses, compares the pieces of earlier rounds.
  out_.live_from = finished_first(out_.pieces, paths_, in_.before);
}

void FleetSolve::take_frames(const FrameSolver& solver) {
  out_.frames = frames_of(paths_, solver.frames());
  seen_ = agreeing(paths_, out_, found_->seen, in_.settings);
  if (in_.memory != nullptr) in_.memory->of_frames.clear();
}

void FleetSolve::estimate() {
  const std::span<const PathSubmap> pieces(out_.pieces);
  JointRanges ranges = ranges_;  // other frames have other walls
  if (in_.settings.joint.sight) {
    suspect_through_walls(pieces, out_.frames, in_.settings.ranging, FramesAre::kFound, ranges);
  }
  const GroupInput group{paths_,       pieces.subspan(out_.live_from),
                         out_.frames,  ranges,
                         starts_,      biases_of(paths_, ranges, in_.knowledge.biases),
                         in_.settings, seen_,
                         in_.before,   in_.memory,
                         in_.stop};
  out_.estimate = {};
  for (std::size_t g = 0; g < out_.frames.groups.size() && !in_.stop.raised(); ++g) {
    auto boundaries =
        estimate_group(group, g, executor_, out_.estimate,
                       g == 0 ? std::span<const Time>(in_.ends) : std::span<const Time>());
    if (g == 0) out_.boundaries = std::move(boundaries);
  }
}

/// Tests the frames against the loops that they reject. If none of these agrees with the new
/// frames, the old ones are kept, and nothing is solved twice. @return whether the frames have
/// changed
bool FleetSolve::frames_rejected() {
  const InitSettings& init = in_.settings.init;
  std::vector<Loop> refused =
      add_refused_loops(paths_, out_.estimate.loops, init, found_->evidence);
  if (refused.empty()) return false;
  FrameSolver again = solved(paths_, found_->evidence, ranges_, init, in_.stop);
  const PathFrames frames = frames_of(paths_, again.frames());
  std::erase_if(refused, [&](const Loop& loop) { return !agrees(paths_, loop, frames, init); });
  if (refused.empty()) return false;
  found_->solver = std::move(again);
  take_frames(found_->solver);
  seen_.insert(seen_.end(), refused.begin(), refused.end());
  return true;
}

/// For vehicles with known frames, the group has reported the offset already.
void FleetSolve::report_contradicted_starts() {
  for (const ContradictedStart& start : found_->contradicted) {
    if (out_.frames.group[start.relative_to] == out_.frames.group[start.path]) continue;
    RejectedStart rejected{paths_[start.relative_to].vehicle(), paths_[start.path].vehicle()};
    rejected.contradicted_by = start.comparisons;
    out_.estimate.rejected_starts.push_back(rejected);
  }
}

/// Reports for all vehicles outside the map what is missing to join them.
void FleetSolve::report_who_waits() {
  VehicleNames names;
  for (const VehiclePath& path : paths_) names[path.vehicle()] = path.name();
  // The solver's text relates a vehicle to the reference. If the reference is not in the map, the
  // text of the map's first vehicle is used for its group.
  const std::size_t reference = out_.estimate.frames[0].group;
  const std::size_t of_map = out_.frames.groups[0].front();
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    VehicleFrame& frame = out_.estimate.frames[i];
    if (frame.group == 0) continue;
    const std::size_t who = frame.group == reference ? of_map : i;
    frame.waits_for = found_->solver.text(stream_of(paths_[who]), names);
  }
}

}  // namespace

Solution solve_fleet(SolutionInput in, Executor& executor) {
  if (in.paths.empty()) return {};
  std::vector<VehiclePath> upright_paths;
  if (in.settings.join && in.paths.size() > 1 && in.settings.solve == SolveWhat::kAll) {
    upright_paths = upright(in.paths, in.settings.cut, in.settings.places, executor);
  }
  const std::span<const VehiclePath> paths = upright_paths.empty() ? in.paths : upright_paths;
  return FleetSolve(in, paths, executor).run();
}

}  // namespace rali::fleet
