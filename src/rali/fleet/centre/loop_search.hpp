#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/settings.hpp"
#include "rali/base/stop_flag.hpp"
#include "rali/fleet/centre/path_submaps.hpp"

namespace rali::fleet {

/// Settings of the loop search.
struct LoopSettings {
  bool use = true;
  int passes = 2;
  int per_submap = 3;
  double apart_m = 25.0;
  double sigma_min_m = 0.05;
  int degenerate_tries = 8;
  int scans_only_tries = 24;
  int row = 3;
  bool veto = true;
  double slide_max_m = 0.5;
  double bend_per_m = 0.01;
  double view_step_m = 2.0;

  template <class V>
  void visit(V& v) {
    v("use", use, "search loop closures and add them to the map");
    v("passes", passes, 1, 10, "searches, each with what the last one taught");
    v("per_submap", per_submap, 1, 100, "largest number of submaps that a submap is compared with");
    v("apart_m", apart_m, 1.0, 1000.0,
      "distance travelled between submaps of one path that are compared");
    v("sigma_min_m", sigma_min_m, 0.0, 10.0,
      "submaps of one path with a smaller sigma are not compared");
    v("unguided_tries", degenerate_tries, 0, 1000,
      "submaps compared where no guess relates two paths");
    v("scans_only_tries", scans_only_tries, 0, 1000,
      "the same where neither ranges nor start poses exist");
    v("row", row, 0, 100, "neighbours on each side that must look alike, too, in a row");
    v("veto", veto, "a loop that contradicts paths and ranges is none");
    v("slide_max_m", slide_max_m, 0.0, 1000.0,
      "a loop is ignored if the error along its degenerate direction is larger: passages bend");
    v("bend_per_m", bend_per_m, 0.0, 1.0,
      "what a loop leaves open along a passage it may be wrong by across, per metre, and turned by "
      "[m, rad]: a passage of radius 100 m");
    v("view_step_m", view_step_m, 0.0, 100.0,
      "distance travelled between compared submaps of two paths");
  }
};

/// Two pieces of paths to compare, and their predicted transform if it is known.
struct LoopCandidate {
  std::size_t target = 0, source = 0;  ///< indices of submaps
  std::optional<places::Guess> guess;
};

/// Result of comparing them.
struct LoopFound {
  LoopCandidate candidate;
  places::Recognition recognition;
};

/// Predicted transform of submap `source` in submap `target`, by the estimate; nothing if it is
/// unknown.
using GuessOf = std::function<std::optional<places::Guess>(std::size_t target, std::size_t source)>;

/// Pairs that may overlap by the guess: of each submap the few nearest others of each path.
[[nodiscard]] std::vector<LoopCandidate> near_candidates(std::span<const PathSubmap> submaps,
                                                         const GuessOf& guess_of,
                                                         const places::NearSettings& near,
                                                         const LoopSettings& settings);

/// Pairs of two paths that look alike in a row: with their neighbours, driven in the same or the
/// opposite direction. The best candidate of each piece comes first, so that a few pieces similar
/// to all others do not use up all tries.
[[nodiscard]] std::vector<LoopCandidate> alike_candidates(
    std::span<const PathSubmap> submaps, std::size_t path_a, std::size_t path_b,
    const places::DescriptorSettings& descriptor, const LoopSettings& settings, int tries);

/// Compares them all. @param stop if it is raised, the remaining ones are returned as not alike
[[nodiscard]] std::vector<LoopFound> compare_all(std::span<const PathSubmap> submaps,
                                                 std::vector<LoopCandidate> candidates,
                                                 const places::RecogniseSettings& settings,
                                                 Executor& executor, StopFlag stop = {});

}  // namespace rali::fleet
