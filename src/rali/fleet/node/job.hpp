#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "rali/base/executor.hpp"

namespace rali::fleet {

/// Purpose of a job. A node runs at most one estimate and one exploration at a time.
enum class JobKind : std::uint8_t {
  kEstimate,   ///< the map as it is now
  kEndRound,   ///< the last one of a sealed round
  kExplore,    ///< frontier search and goal assignment
  kNextAnchor  ///< likewise for a sealed round: selects the next anchor
};

/// Whether it searches frontiers; else it estimates.
[[nodiscard]] constexpr bool explores(JobKind kind) {
  return kind == JobKind::kExplore || kind == JobKind::kNextAnchor;
}

/// Result of a job that has returned.
enum class JobOutcome : std::uint8_t {
  kTaken,    ///< its result is valid from now on
  kDropped,  ///< it was cancelled or is stale; its inputs are returned
  kLost      ///< not the job that was made: its inputs must be rebuilt
};

/// Amount of work of a job: its duration is estimated from this where no clock is read.
struct JobWork {
  std::size_t nodes = 0;           ///< of all graphs that were solved, in sum
  std::size_t submaps = 0;         ///< that were made
  std::size_t compared = 0;        ///< pairs of submaps
  std::size_t cells_drawn = 0;     ///< of the grid, for keyframes
  std::size_t cells_searched = 0;  ///< for frontiers and paths
};

/// Work that is too long for a step (architecture.md 4): its input does not change while it runs,
/// and its result stays inside until the node gets it back.
class Job {
 public:
  virtual ~Job() = default;

  /// Called once, in any thread; nobody else touches the job until it returns. Reads no clock: the
  /// same input gives the same result, whatever the executor's number of threads. Does not throw.
  /// @param cancel polled at least once per iteration of a solver: when it is set, run() returns
  ///               soon, and the job's inputs are as they were before
  virtual void run(Executor& executor, const std::atomic<bool>& cancel) = 0;

  /// After run().
  [[nodiscard]] virtual JobWork work() const = 0;
};

}  // namespace rali::fleet
