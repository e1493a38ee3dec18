#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "rali/fleet/centre/loop_search.hpp"

namespace rali::fleet {

/// What comparing pieces of path has brought in earlier solutions. A comparison depends on its two
/// pieces and on its guess alone: while these stay, it is made once, in however many solutions the
/// pair comes up, and what was refused is remembered like what was found. A piece with other scans
/// is another piece. One that is levelled anew by a little is not: the bodies lie to each other as
/// they did.
class ComparedPieces {
 public:
  /// As compare_all(), but only of pairs that are new.
  /// @param settings the same in each call
  /// @param stop where it is raised nothing is remembered
  [[nodiscard]] std::vector<LoopFound> compare(std::span<const PathSubmap> submaps,
                                               std::vector<LoopCandidate> candidates,
                                               const places::RecogniseSettings& settings,
                                               Executor& executor, StopFlag stop = {});

  /// How many comparisons were made, not remembered.
  [[nodiscard]] std::size_t made() const { return made_; }

 private:
  /// A piece as it was when it was compared.
  struct Piece {
    explicit Piece(const places::Submap& submap);

    /// The same scans, levelled nearly the same.
    [[nodiscard]] bool is(const places::Submap& submap) const;

    std::vector<KeyframeId> scans;
    std::size_t points = 0;  ///< finer points of the same scans may come later
    double path_m = 0.0;
    geometry::SE3 T_ref_body;
  };

  struct Known {
    Piece target, source;
    std::optional<places::Guess> guess;
    places::Recognition recognition;
  };

  using Pair = std::pair<KeyframeId, KeyframeId>;  ///< middles of target and source

  [[nodiscard]] const Known* find(const places::Submap& target, const places::Submap& source,
                                  const std::optional<places::Guess>& guess) const;

  std::map<Pair, Known> known_;  ///< the latest of each pair
  std::size_t made_ = 0;
};

}  // namespace rali::fleet
