#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/settings.hpp"
#include "rali/base/time.hpp"
#include "rali/fleet/node/events.hpp"

namespace rali::drive {

/// The computers of simulated vehicles.
struct ComputerSettings {
  double cpu_factor = 1.0;

  template <class V>
  void visit(V& v) {
    v("cpu_factor", cpu_factor, 0.0, 1e4,
      "how many times longer than measured a job of the anchor takes");
  }
};

/// How long a job takes, computed from its amount of work instead of a clock, so that runs repeat.
/// Fitted to the CPU times of 26 estimates (0.09 to 3.7 s; the fit is within a factor of 1.7 of
/// each) and of 144 explorations (1 to 74 ms; most take half of the fit, those that plan many paths
/// twice as long), see drive/README.md for the command.
struct JobCost {
  double job_s = 0.0;
  double node_s = 0.001;
  double submap_s = 0.008;
  double compared_s = 0.020;
  double cell_drawn_s = 8e-9;
  double cell_searched_s = 12e-9;

  /// `job_s` applies to estimates only.
  [[nodiscard]] Duration of(fleet::JobKind kind, const fleet::JobWork& work) const;
};

/// Runs the jobs of all vehicles of one process in virtual time. Each is computed at once and
/// delivered when its simulated duration is over. Every vehicle has a core of its own for them.
class SimulatedJobs {
 public:
  SimulatedJobs(const ComputerSettings& computer, const JobCost& cost)
      : computer_(computer), cost_(cost) {}

  void run(std::size_t owner, const fleet::RunJob& order, Time now, Executor& executor);

  /// A running job is delivered at once.
  void cancel(std::size_t owner, std::uint64_t number, Time now);

  /// Drops the jobs of a process that has ended: its successor numbers its jobs from the start.
  void forget(std::size_t owner);

  struct Done {
    std::size_t owner = 0;
    fleet::JobDone event;
  };

  /// CPU time that a job took in this process; JobCost is fitted to it. Differs between equal runs.
  struct Spent {
    fleet::JobKind kind = fleet::JobKind::kEstimate;
    fleet::JobWork work;
    double cpu_s = 0.0;
  };

  [[nodiscard]] const std::vector<Spent>& spent() const { return spent_; }

  /// Jobs finished up to now, in the order of their completion.
  [[nodiscard]] std::vector<Done> take(Time now);

 private:
  struct Entry {
    Time due;
    Done done;
  };

  ComputerSettings computer_;
  JobCost cost_;
  std::vector<Spent> spent_;
  std::vector<Entry> under_way_;  ///< in the order in which they started
};

}  // namespace rali::drive
