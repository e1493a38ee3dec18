#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "rali/fleet/centre/loop_search.hpp"

namespace rali::fleet {

/// Results of comparing pieces of paths in earlier solutions. A comparison depends only on its two
/// pieces and its guess: while these are unchanged, it is made once, however many solutions need
/// it. Rejections are stored like matches. A piece with other scans is a different piece. One whose
/// levelling has changed slightly is not: the relation of the bodies is unchanged.
class ComparedPieces {
 public:
  /// As compare_all(), but only of pairs that are new.
  /// @param settings the same in each call
  /// @param stop if it is raised, nothing is stored
  [[nodiscard]] std::vector<LoopFound> compare(std::span<const PathSubmap> submaps,
                                               std::vector<LoopCandidate> candidates,
                                               const places::RecogniseSettings& settings,
                                               Executor& executor, StopFlag stop = {});

  /// Number of comparisons that were made, not read from memory.
  [[nodiscard]] std::size_t made() const { return made_; }

 private:
  /// State of a piece when it was compared.
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
