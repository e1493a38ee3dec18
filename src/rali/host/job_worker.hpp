#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/fleet/node/events.hpp"
#include "rali/host/bounded_queue.hpp"
#include "rali/host/duration_stats.hpp"

namespace rali::host {

/// Runs the jobs of a node beside its steps, one after the other, in a thread of its own.
class JobWorker {
 public:
  explicit JobWorker(std::unique_ptr<Executor> executor);

  /// Cancels what is under way and waits for its end.
  ~JobWorker();

  JobWorker(const JobWorker&) = delete;
  JobWorker& operator=(const JobWorker&) = delete;

  void run(fleet::RunJob order);

  /// The job returns soon; its JobDone comes all the same.
  void cancel(std::uint64_t number);

  /// Jobs that have ended since the last call, in the order of their ends.
  [[nodiscard]] std::vector<fleet::JobDone> take() { return done_.take(); }

  /// The longest that has ended so far [s].
  [[nodiscard]] double longest_s() const { return longest_s_.load(std::memory_order_relaxed); }

 private:
  void loop();

  std::unique_ptr<Executor> executor_;
  BoundedQueue<fleet::RunJob> orders_{16};
  BoundedQueue<fleet::JobDone> done_{16};
  std::mutex mutex_;  ///< of flags_
  std::map<std::uint64_t, std::shared_ptr<std::atomic<bool>>> flags_;
  std::atomic<bool> end_{false};
  std::atomic<double> longest_s_{0.0};
  std::thread thread_;
};

}  // namespace rali::host
