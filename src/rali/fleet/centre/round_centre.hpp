#pragma once

#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/stop_flag.hpp"
#include "rali/fleet/centre/centre.hpp"
#include "rali/fleet/centre/separator_history.hpp"
#include "rali/fleet/centre/solution.hpp"

namespace rali::fleet {

/// The finished rounds of another anchor as an estimate: frames and keyframes before its separator.
/// Nothing: the separator prior does not fit the paths, or a keyframe is missing.
[[nodiscard]] std::optional<FleetEstimate> finished_before(
    const SeparatorPrior& separator, std::span<const VehiclePath> paths,
    const std::map<KeyframeId, KeyframePose>& keyframes, const FleetSettings& settings);

/// The centre over a mission of many rounds: it keeps what it has solved. Nodes of finished rounds
/// stay at their estimate from the end of their round. The information of their facts on later
/// nodes becomes a prior on the nodes at the separator. Only the current round is solved (paper,
/// "Incremental Global PGO"; algorithms_fleet 8.5). If a loop to an earlier round closes, or the
/// separator prior proves wrong, everything after an earlier separator is solved again. All facts
/// are solved if there is none, and while not all vehicles share a frame. With SolveWhat::kAll it
/// is a Centre.
class RoundCentre {
 public:
  RoundCentre(const FleetSettings& settings, FleetKnowledge knowledge);

  void add(const FactPtr& fact) { centre_.add(fact); }

  void add(Fact fact) { centre_.add(std::move(fact)); }

  /// Solves for all known facts. @param stop if it is raised meanwhile, nothing changes
  const FleetEstimate& estimate(Executor& executor, StopFlag stop = {});

  /// The same, and then ends the round: everything up to `t` is finished, or up to the earliest
  /// last node of the vehicles that sent facts in this round.
  const FleetEstimate& end_round(Time t, Executor& executor, StopFlag stop = {});

  /// Continues from the last anchor: its separator prior and its poses of earlier keyframes.
  /// @return false: it does not fit the local facts, or a keyframe is missing; nothing is
  /// changed then, and the next estimate is one of all facts
  bool take_over(const SeparatorPrior& separator,
                 const std::map<KeyframeId, KeyframePose>& keyframes);

  /// Frees points that only estimates of finished rounds would need; other estimates need none.
  void forget_finished_points();

  [[nodiscard]] const std::vector<VehiclePath>& paths() const { return centre_.paths(); }

  [[nodiscard]] const FleetEstimate& last() const { return last_; }

  [[nodiscard]] const std::optional<SeparatorPrior>& separator() const { return separator_; }

  /// Cost of the solutions so far.
  struct Work {
    std::size_t whole = 0, rounds = 0;  ///< solutions of each kind
    std::size_t reopened = 0;           ///< of the rounds: such on an earlier separator
    std::size_t nodes = 0;              ///< of the last one
    std::size_t pieces = 0;             ///< of paths, kept for loops
    std::size_t all_nodes = 0;          ///< of all solutions, in sum
    std::size_t cut = 0, compared = 0;  ///< pieces, and pairs of pieces
  };

  [[nodiscard]] const Work& work() const { return work_; }

 private:
  /// State that a solution changes; the pieces of paths are returned by the solution itself.
  struct Saved {
    FleetEstimate done;
    std::optional<SeparatorPrior> separator;
    SeparatorHistory history;
    std::vector<std::size_t> cut_from;
    LoopMemory memory;
  };

  void solve(std::optional<Time> until, Executor& executor, StopFlag stop);
  // False if the flag is raised: then all but the pieces must be restored.
  [[nodiscard]] bool solve_from_separator(std::vector<Time> ends, Executor& executor);
  [[nodiscard]] bool solve_all(std::vector<Time> ends, Executor& executor);
  [[nodiscard]] Solution solve_round(std::vector<Time> ends, Executor& executor);
  [[nodiscard]] Solution solve_for(SolutionInput in, Executor& executor);
  [[nodiscard]] Saved saved() const;
  void restore(Saved saved);
  [[nodiscard]] bool separator_holds() const;
  [[nodiscard]] bool separator_moved(const FleetEstimate& estimate) const;
  [[nodiscard]] std::vector<std::size_t> look_back(const Solution& solution,
                                                   std::span<const std::size_t> lately,
                                                   Executor& executor);
  [[nodiscard]] bool go_back(std::span<const std::size_t> nodes, std::size_t steps,
                             std::vector<Time>& ends);
  void take(std::vector<SeparatorPrior> boundaries);

  /// Relative pose of two keyframes by an estimate.
  struct Between {
    geometry::SE3 T_map_from, T_map_to;
    geometry::Mat6 covariance;  ///< of relative_covariance(), upper bound
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
  FleetEstimate done_;  ///< of the nodes before the separator; frames and groups of all
  std::optional<SeparatorPrior> separator_;
  SeparatorHistory history_;          ///< before separator_
  std::optional<PathFrames> frames_;  ///< once all vehicles share one
  std::vector<StreamKey> streams_;    ///< of the paths that pieces_ and frames_ index
  LoopMemory memory_;
  ComparedPieces compared_;
  std::vector<PathSubmap> pieces_;     ///< of finished rounds
  std::vector<std::size_t> cut_from_;  ///< earlier nodes have been cut
  StopFlag stop_;                      ///< of the current solution
  Work work_;
};

}  // namespace rali::fleet
