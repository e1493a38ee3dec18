#include "rali/fleet/centre/frame_search.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "rali/fleet/centre/path_frames.hpp"
#include "rali/fleet/centre/scan_evidence.hpp"
#include "rali/fleet/centre/sight_lines.hpp"
#include "rali/fleet/centre/start_between.hpp"

namespace rali::fleet {

FrameSolver solved(std::span<const VehiclePath> paths, const FrameSolver& evidence,
                   const JointRanges& ranges, const InitSettings& settings, StopFlag stop) {
  FrameSolver solver = evidence;
  add_ranges(paths, ranges, solver);
  // All data is recorded, so the consecutive evaluations that a commit requires are identical. Each
  // join restarts the count of all other links.
  Time t;
  for (const VehiclePath& path : paths) t = std::max(t, path.nodes().back().t);
  const int rounds = settings.commit.evaluations * static_cast<int>(paths.size());
  for (int i = 0; i < rounds && !stop.raised(); ++i) {
    solver.evaluate(t);
    t = t + Duration::from_s(settings.commit.spacing_s);
  }
  return solver;
}

namespace {

/// Determines the frames of all paths: by ranges, start poses and scan comparisons.
class FrameSearch {
 public:
  FrameSearch(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
              const FleetSettings& settings, Executor& executor, ComparedPieces& compared,
              StopFlag stop)
      : paths_(paths),
        submaps_(submaps),
        settings_(settings),
        executor_(executor),
        compared_(compared),
        stop_(stop),
        made_before_(compared.made()),
        evidence_(settings.init, stream_of(paths.front())) {
    for (const VehiclePath& path : paths) {
      evidence_.add_vehicle(stream_of(path));
      evidence_.set_keyframes(stream_of(path), static_cast<int>(path.points().size()));
    }
  }

  FoundFrames run(JointRanges ranges, const std::vector<StartPrior>& starts);

 private:
  /// Results of comparisons whose guess came from a start pose.
  struct Fit {
    int found = 0, contradicted = 0;
  };

  void gather(const std::vector<StartPrior>& starts, int tries);
  void look_by_start(const StartPrior& start);
  [[nodiscard]] std::optional<std::size_t> index_of(StreamKey key) const;
  [[nodiscard]] bool holds_between(std::size_t a, std::size_t b) const;
  [[nodiscard]] std::optional<StartPrior> start_of(std::size_t a, std::size_t b) const;
  Fit look_near(const StartPrior& start);
  Fit look(std::vector<LoopCandidate> candidates);
  bool test_hypotheses(const FleetFrames& frames);
  [[nodiscard]] std::vector<LoopCandidate> predicted_by(const FleetFrames& frames,
                                                        const OpenLink& link,
                                                        const YawPose& T_b_a) const;
  [[nodiscard]] bool mark_blocked(const FleetFrames& frames, JointRanges& ranges) const;

  std::span<const VehiclePath> paths_;
  std::span<const PathSubmap> submaps_;
  const FleetSettings& settings_;
  Executor& executor_;
  ComparedPieces& compared_;
  StopFlag stop_;
  std::size_t made_before_;
  FrameSolver evidence_;  ///< all but the ranges
  std::vector<LoopFound> seen_;
  std::vector<ContradictedStart> contradicted_;
  std::vector<GivenStart> holding_;  ///< start poses that are not contradicted
  int groups_ = 0;
};

FrameSearch::Fit FrameSearch::look(std::vector<LoopCandidate> candidates) {
  constexpr double kConflict = 0.1;  // nine in ten correct placements have less than 0.035
  Fit fit;
  for (LoopFound& found : compared_.compare(submaps_, std::move(candidates),
                                            settings_.places.recognise, executor_, stop_)) {
    add_scan_evidence(paths_, submaps_, found, {groups_++, false}, settings_.init, evidence_);
    fit.found += found.recognition.found() ? 1 : 0;
    fit.contradicted += found.recognition.conflict_as_guessed > kConflict ? 1 : 0;
    if (found.recognition.usable()) seen_.push_back(std::move(found));
  }
  return fit;
}

/// Compares pieces that should overlap by a start pose.
FrameSearch::Fit FrameSearch::look_near(const StartPrior& start) {
  std::vector<LoopCandidate> near =
      near_candidates(submaps_,
                      guess_from_start(paths_, submaps_, start.relative_to, start.path,
                                       start.T_relative_path, start.sigma_m, start.sigma_rad),
                      settings_.places.near, settings_.loops);
  near.resize(std::min(near.size(), static_cast<std::size_t>(settings_.loops.degenerate_tries)));
  return look(std::move(near));
}

/// The start pose is evidence unless the scans contradict it: it predicts overlaps, and none of
/// them is found. One that is merely unconfirmed is accepted without further evidence.
void FrameSearch::look_by_start(const StartPrior& start) {
  const Fit fit = look_near(start);
  const int limit = settings_.init.prior.contradicted_by;
  if (limit > 0 && fit.found == 0 && fit.contradicted >= limit) {
    contradicted_.push_back({start.relative_to, start.path, fit.contradicted});
    return;
  }
  add_start(paths_[start.relative_to], paths_[start.path], start.T_relative_path, start.sigma_m,
            start.sigma_rad, settings_.init, evidence_);
  holding_.push_back({.relative_to = paths_[start.relative_to].vehicle(),
                      .vehicle = paths_[start.path].vehicle(),
                      .T_relative_vehicle = start.T_relative_path,
                      .sigma_m = start.sigma_m,
                      .sigma_rad = start.sigma_rad});
}

std::optional<std::size_t> FrameSearch::index_of(StreamKey key) const {
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    if (stream_of(paths_[i]) == key) return i;
  }
  return std::nullopt;
}

bool FrameSearch::holds_between(std::size_t a, std::size_t b) const {
  return std::any_of(holding_.begin(), holding_.end(), [&](const GivenStart& s) {
    return std::minmax(s.relative_to, s.vehicle) ==
           std::minmax(paths_[a].vehicle(), paths_[b].vehicle());
  });
}

/// Start of path b relative to that of a, by a chain of accepted start poses.
std::optional<StartPrior> FrameSearch::start_of(std::size_t a, std::size_t b) const {
  const auto chain = start_between(holding_, paths_[a].vehicle(), paths_[b].vehicle());
  if (!chain) return std::nullopt;
  return StartPrior{a, b, chain->T_relative_vehicle, chain->sigma_m, chain->sigma_rad};
}

/// Start poses first, then the pairs without one of their own. If a chain of start poses relates
/// them, pieces that should overlap are compared; else any that look alike.
void FrameSearch::gather(const std::vector<StartPrior>& starts, int tries) {
  for (const StartPrior& start : starts) {
    if (!holds_between(start.relative_to, start.path)) look_by_start(start);
  }
  for (std::size_t b = 0; b < paths_.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      if (holds_between(a, b)) continue;
      const std::optional<StartPrior> chain = start_of(a, b);
      if (chain && look_near(*chain).found > 0) continue;
      look(alike_candidates(submaps_, a, b, settings_.places.descriptor, settings_.loops, tries));
    }
  }
}

/// Pieces that are nearest to each other if a hypothesis of a link is true, nearest first.
std::vector<LoopCandidate> FrameSearch::predicted_by(const FleetFrames& frames,
                                                     const OpenLink& link,
                                                     const YawPose& T_b_a) const {
  const FrameGroup& a = frames.groups[link.a].frames;
  const FrameGroup& b = frames.groups[link.b].frames;
  const SearchSettings& search = settings_.init.search;
  std::vector<LoopCandidate> out;
  for (std::size_t i = 0; i < a.keys.size(); ++i) {
    for (std::size_t j = 0; j < b.keys.size(); ++j) {
      const auto path_a = index_of(a.keys[i]), path_b = index_of(b.keys[j]);
      if (!path_a || !path_b) continue;
      const YawPose T = b.T_ref_odom[j].inverse() * T_b_a * a.T_ref_odom[i];
      // Hypotheses nearer than these limits are one: about two sigma.
      const GuessOf guess =
          guess_from_frames(paths_, submaps_, *path_b, *path_a, T, 0.5 * search.merge_m,
                            0.5 * search.merge_deg * kDegree);
      for (LoopCandidate& c :
           near_candidates(submaps_, guess, settings_.places.near, settings_.loops)) {
        // Farther apart, the scans of a true hypothesis need not agree.
        if (c.guess->T_target_source.p.norm() < settings_.cut.length_m) out.push_back(std::move(c));
      }
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const LoopCandidate& p, const LoopCandidate& q) {
    return p.guess->T_target_source.p.norm() < q.guess->T_target_source.p.norm();
  });
  return out;
}

/// Where the paths are alike in many places, as in a tunnel, comparisons of similar pieces say
/// little. But each hypothesis predicts where the paths meet: of the true one, the scans agree
/// there. The nearest pieces of all hypotheses of a link are one group, the second nearest another:
/// at most one hypothesis is true.
/// @return whether there is new evidence
bool FrameSearch::test_hypotheses(const FleetFrames& frames) {
  constexpr std::size_t kHypotheses = 4, kTests = 2;
  bool any = false;
  for (const OpenLink& link : frames.links) {
    if (stop_.raised() || link.T_b_a.size() < 2) continue;
    for (std::size_t k = 0; k < std::min(kHypotheses, link.T_b_a.size()); ++k) {
      std::vector<LoopCandidate> nearest = predicted_by(frames, link, link.T_b_a[k]);
      nearest.resize(std::min(kTests, nearest.size()));
      int group = groups_;
      for (const LoopFound& found : compared_.compare(
               submaps_, std::move(nearest), settings_.places.recognise, executor_, stop_)) {
        add_scan_evidence(paths_, submaps_, found, {group++, true}, settings_.init, evidence_);
        any = any || found.recognition.found();
      }
    }
    groups_ += static_cast<int>(kTests);
  }
  return any;
}

/// Ranges through walls contradict every frame, even one that several scan matches support. If that
/// frame is right, its map contains the walls.
/// @return whether there are such ranges
bool FrameSearch::mark_blocked(const FleetFrames& frames, JointRanges& ranges) const {
  for (const OpenLink& link : frames.links) {
    const bool scans_agree = link.views >= settings_.init.commit.views_min;
    if (link.decision.advice != Advice::kMisfit || !scans_agree) continue;
    const auto blocked = [](const JointRange& r) { return r.blocked; };
    const auto before = std::count_if(ranges.ranges.begin(), ranges.ranges.end(), blocked);
    suspect_through_walls(submaps_, frames_of(paths_, joined(frames, link)), settings_.ranging,
                          FramesAre::kSupposed, ranges);
    if (std::count_if(ranges.ranges.begin(), ranges.ranges.end(), blocked) > before) return true;
  }
  return false;
}

FoundFrames FrameSearch::run(JointRanges ranges, const std::vector<StartPrior>& starts) {
  const LoopSettings& loops = settings_.loops;
  gather(starts, ranges.ranges.empty() ? loops.scans_only_tries : loops.degenerate_tries);
  FrameSolver solver = solved(paths_, evidence_, ranges, settings_.init, stop_);
  if (!ranges.ranges.empty() && test_hypotheses(solver.frames())) {
    solver = solved(paths_, evidence_, ranges, settings_.init, stop_);
  }
  const std::size_t compared = compared_.made() - made_before_;
  if (!settings_.joint.sight) {
    return {std::move(evidence_), std::move(solver), std::move(seen_), compared,
            std::move(contradicted_)};
  }
  // Repeats after each join, while further ranges are found to be blocked.
  for (FleetFrames frames = solver.frames(); !stop_.raised() && mark_blocked(frames, ranges);) {
    FrameSolver again = solved(paths_, evidence_, ranges, settings_.init, stop_);
    const std::size_t groups = frames.groups.size();
    frames = again.frames();
    if (frames.groups.size() >= groups) break;
    solver = std::move(again);
  }
  return {std::move(evidence_), std::move(solver), std::move(seen_), compared,
          std::move(contradicted_)};
}

}  // namespace

FoundFrames find_frames(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
                        const JointRanges& ranges, const std::vector<StartPrior>& starts,
                        const FleetSettings& settings, Executor& executor, ComparedPieces* compared,
                        StopFlag stop) {
  ComparedPieces none;
  return FrameSearch(paths, submaps, settings, executor, compared != nullptr ? *compared : none,
                     stop)
      .run(ranges, starts);
}

}  // namespace rali::fleet
