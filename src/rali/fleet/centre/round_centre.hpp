#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/stop_flag.hpp"
#include "rali/fleet/centre/boundary_history.hpp"
#include "rali/fleet/centre/centre.hpp"
#include "rali/fleet/centre/solution.hpp"

namespace rali::fleet {

/// What another anchor has left of finished rounds, as an estimate: frames and keyframes before its
/// boundary. Nothing: the boundary does not fit the paths, or a keyframe is missing.
[[nodiscard]] std::optional<FleetEstimate> finished_before(
    const RoundBoundary& boundary, std::span<const VehiclePath> paths,
    const std::map<KeyframeId, KeyframePose>& keyframes, const FleetSettings& settings);

/// The centre over a mission of many rounds: it keeps what it has solved. Nodes of finished rounds
/// stay where the end of their round left them, and all that their facts say about what follows is
/// a prior on the nodes at the boundary; the current round alone is solved (paper, "Incremental
/// Global PGO"; algorithms_fleet 8.5). When a loop to an earlier round closes, or the boundary
/// turns out to be wrong, what came after an earlier boundary is solved again; where there is none,
/// and while not all vehicles share a frame, everything is. With SolveWhat::kAll it is a Centre.
class RoundCentre {
 public:
  RoundCentre(const FleetSettings& settings, FleetKnowledge knowledge);

  void add(const Fact& fact) { centre_.add(fact); }

  /// Solves for what is known. @param stop where it is raised meanwhile, all stays as it was
  const FleetEstimate& estimate(Executor& executor, StopFlag stop = {});

  /// The same, and then the round is over: what is known up to `t`, or to the last word of whoever
  /// told something in this round, is finished.
  const FleetEstimate& end_round(Time t, Executor& executor, StopFlag stop = {});

  /// Goes on from what the last anchor left: its boundary and where it had the keyframes before it.
  /// @return false: it does not fit the facts that are here, or a keyframe is missing; nothing is
  /// changed then, and the next estimate is one of all facts
  bool take_over(const RoundBoundary& boundary,
                 const std::map<KeyframeId, KeyframePose>& keyframes);

  /// Points that only estimates of finished rounds would need; other than these need no points.
  void forget_finished_points();

  [[nodiscard]] const std::vector<VehiclePath>& paths() const { return centre_.paths(); }

  [[nodiscard]] const FleetEstimate& last() const { return last_; }

  [[nodiscard]] const std::optional<RoundBoundary>& boundary() const { return boundary_; }

  /// What the solutions have cost so far.
  struct Work {
    std::size_t whole = 0, rounds = 0;  ///< solutions of each kind
    std::size_t reopened = 0;           ///< of those of rounds, such on an earlier boundary
    std::size_t nodes = 0;              ///< of the last one
    std::size_t pieces = 0;             ///< of path that are kept for loops
    std::size_t all_nodes = 0;          ///< of all solutions, in sum
    std::size_t cut = 0, compared = 0;  ///< pieces, and pairs of pieces
  };

  [[nodiscard]] const Work& work() const { return work_; }

 private:
  /// What a solution changes on its way; the pieces of path it gives back itself.
  struct Saved {
    FleetEstimate done;
    std::optional<RoundBoundary> boundary;
    BoundaryHistory history;
    std::vector<std::size_t> cut_from;
    LoopMemory memory;
  };

  void solve(std::optional<Time> until, Executor& executor, StopFlag stop);
  // False where the flag is raised: then all but the pieces has to be restored.
  [[nodiscard]] bool solve_from_boundary(std::vector<Time> ends, Executor& executor);
  [[nodiscard]] bool solve_all(std::vector<Time> ends, Executor& executor);
  [[nodiscard]] Solution solve_round(std::vector<Time> ends, Executor& executor);
  [[nodiscard]] Solution solve_for(SolutionInput in, Executor& executor);
  [[nodiscard]] Saved saved() const;
  void restore(Saved saved);
  [[nodiscard]] bool boundary_holds() const;
  [[nodiscard]] bool boundary_moved(const FleetEstimate& estimate) const;
  [[nodiscard]] std::vector<std::size_t> look_back(const Solution& solution,
                                                   std::span<const std::size_t> lately,
                                                   Executor& executor);
  [[nodiscard]] bool go_back(std::span<const std::size_t> nodes, std::size_t steps,
                             std::vector<Time>& ends);
  void take(std::vector<RoundBoundary> boundaries);

  /// How two keyframes lie to each other by an estimate.
  struct Between {
    geometry::SE3 T_map_from, T_map_to;
    geometry::Mat6 covariance;  ///< of relative_covariance(), at most
  };

  [[nodiscard]] std::optional<Between> between(KeyframeId from, KeyframeId to,
                                               const FleetEstimate& live) const;
  [[nodiscard]] bool worth_it(const Loop& loop, const Between& between, bool near) const;
  [[nodiscard]] bool may_hold(const Loop& loop, const geometry::Vec6& error,
                              const geometry::Mat6& covariance) const;
  [[nodiscard]] Time end_of(Time t) const;
  [[nodiscard]] std::vector<std::size_t> begins() const;
  [[nodiscard]] const KeyframePose* pose_of(KeyframeId id, const FleetEstimate& live) const;
  void merge(FleetEstimate live);
  void keep_done();
  void cut_on();
  [[nodiscard]] std::vector<PathSubmap> keep_finished(std::vector<PathSubmap> pieces);
  void finish(std::vector<PathSubmap> pieces);
  void keep(PathSubmap piece);
  void find_pieces();

  Centre centre_;
  FleetEstimate last_;
  FleetEstimate done_;  ///< of the nodes before the boundary; frames and groups of all
  std::optional<RoundBoundary> boundary_;
  BoundaryHistory history_;           ///< before boundary_
  std::optional<PathFrames> frames_;  ///< once all vehicles share one
  std::vector<StreamKey> streams_;    ///< of the paths that pieces_ and frames_ count by
  LoopMemory memory_;
  ComparedPieces compared_;
  std::vector<PathSubmap> pieces_;     ///< of finished rounds
  std::vector<std::size_t> cut_from_;  ///< what is before has been cut
  StopFlag stop_;                      ///< of the solution that is being made
  Work work_;
};

}  // namespace rali::fleet
