#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "rali/base/executor.hpp"

namespace rali::fleet {

/// What a job is for. A node has at most one estimate and one exploration under way.
enum class JobKind : std::uint8_t {
  kEstimate,   ///< the map as it is now
  kEndRound,   ///< the last one of a round that is sealed
  kExplore,    ///< frontiers, and who goes where
  kNextAnchor  ///< likewise of a round that is sealed: who is the next anchor
};

/// Whether it looks for frontiers; else it estimates.
[[nodiscard]] constexpr bool explores(JobKind kind) {
  return kind == JobKind::kExplore || kind == JobKind::kNextAnchor;
}

/// What became of a job that has come back.
enum class JobFate : std::uint8_t {
  kTaken,    ///< its result holds from now on
  kDropped,  ///< it was cancelled or is stale; what it was made from is here again
  kLost      ///< not the job that was made: what it was made from has to be made anew
};

/// What a job had to do: what its duration is estimated by where no clock is read.
struct JobWork {
  std::size_t nodes = 0;           ///< of all graphs that were solved, in sum
  std::size_t submaps = 0;         ///< that were cut
  std::size_t compared = 0;        ///< pairs of submaps
  std::size_t cells_drawn = 0;     ///< of the grid, by keyframes
  std::size_t cells_searched = 0;  ///< by frontiers and paths
};

/// Work that is too long for a step (architecture.md 4): what it is made from does not change while
/// it runs, and its result stays inside until the node gets it back.
class Job {
 public:
  virtual ~Job() = default;

  /// Once, in any thread; nobody else touches the job until it returns. Reads no clock: the same
  /// input gives the same result, whatever the executor's number of threads. Does not throw.
  /// @param cancel polled at least once per iteration of a solver: when it is set, run() returns
  ///        soon, and what the job was made from is as it was before
  virtual void run(Executor& executor, const std::atomic<bool>& cancel) = 0;

  /// After run().
  [[nodiscard]] virtual JobWork work() const = 0;
};

}  // namespace rali::fleet
