#include "rali/fleet/centre/frame_search.hpp"

#include <algorithm>
#include <utility>

#include "rali/fleet/centre/path_frames.hpp"
#include "rali/fleet/centre/scan_evidence.hpp"

namespace rali::fleet {

namespace {

/// Looks for the frames of all paths: by ranges, start poses and what scans say.
class FrameSearch {
 public:
  FrameSearch(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
              const FleetSettings& settings, Executor& executor)
      : paths_(paths),
        submaps_(submaps),
        settings_(settings),
        executor_(executor),
        solver_(settings.init, stream_of(paths.front())) {
    for (const VehiclePath& path : paths) {
      solver_.add_vehicle(stream_of(path));
      solver_.set_keyframes(stream_of(path), static_cast<int>(path.points().size()));
    }
  }

  FrameSolver run(const JointRanges& ranges, const std::vector<StartPrior>& starts);

 private:
  void look(std::vector<LoopCandidate> candidates);

  std::span<const VehiclePath> paths_;
  std::span<const PathSubmap> submaps_;
  const FleetSettings& settings_;
  Executor& executor_;
  FrameSolver solver_;
  int groups_ = 0;
};

void FrameSearch::look(std::vector<LoopCandidate> candidates) {
  for (const LoopFound& found :
       compare_all(submaps_, std::move(candidates), settings_.places.recognise, executor_)) {
    add_scan_evidence(paths_, submaps_, found, groups_++, settings_.init, solver_);
  }
}

FrameSolver FrameSearch::run(const JointRanges& ranges, const std::vector<StartPrior>& starts) {
  add_ranges(paths_, ranges, solver_);
  for (std::size_t b = 0; b < paths_.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const auto start = std::find_if(starts.begin(), starts.end(), [&](const StartPrior& s) {
        return std::minmax(s.path, s.relative_to) == std::minmax(a, b);
      });
      if (start == starts.end()) {
        look(alike_candidates(submaps_, a, b, settings_.places.descriptor, settings_.loops));
        continue;
      }
      add_start(paths_[start->relative_to], paths_[start->path], start->T_relative_path,
                start->sigma_m, start->sigma_rad, settings_.init, solver_);
      std::vector<LoopCandidate> near = near_candidates(
          submaps_,
          guess_from_start(paths_, submaps_, start->relative_to, start->path,
                           start->T_relative_path, start->sigma_m, start->sigma_rad),
          settings_.places.near, settings_.loops);
      near.resize(std::min(near.size(), static_cast<std::size_t>(settings_.loops.blind_tries)));
      look(std::move(near));
    }
  }
  // What is recorded is all there: the evaluations in a row that a frame wants differ in nothing.
  Time t;
  for (const VehiclePath& path : paths_) t = std::max(t, path.nodes().back().t);
  for (int i = 0; i < settings_.init.commit.evaluations; ++i) {
    solver_.evaluate(t);
    t = t + Duration::from_s(settings_.init.commit.spacing_s);
  }
  return std::move(solver_);
}

}  // namespace

FrameSolver find_frames(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
                        const JointRanges& ranges, const std::vector<StartPrior>& starts,
                        const FleetSettings& settings, Executor& executor) {
  return FrameSearch(paths, submaps, settings, executor).run(ranges, starts);
}

}  // namespace rali::fleet
