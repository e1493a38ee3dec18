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

/// Runs jobs outside the steps of a node, one after the other, in a thread of its own.
class JobWorker {
 public:
  explicit JobWorker(std::unique_ptr<Executor> executor);

  /// Cancels the running job and waits for its end.
  ~JobWorker();

  JobWorker(const JobWorker&) = delete;
  JobWorker& operator=(const JobWorker&) = delete;

  /// @param number returned with the job; unique among the jobs in progress here
  void run(std::uint64_t number, std::shared_ptr<fleet::Job> job);

  /// The job returns soon; its JobDone is still delivered.
  void cancel(std::uint64_t number);

  /// Jobs finished since the last call, in the order of completion.
  [[nodiscard]] std::vector<fleet::JobDone> take() { return done_.take(); }

  /// The longest duration of a finished job so far [s].
  [[nodiscard]] double longest_s() const { return longest_s_.load(std::memory_order_relaxed); }

 private:
  void loop();

  std::unique_ptr<Executor> executor_;
  BoundedQueue<fleet::JobDone> orders_{16};  ///< as they will be returned
  BoundedQueue<fleet::JobDone> done_{16};
  std::mutex mutex_;  ///< of flags_
  std::map<std::uint64_t, std::shared_ptr<std::atomic<bool>>> flags_;
  std::atomic<bool> end_{false};
  std::atomic<double> longest_s_{0.0};
  std::thread thread_;
};

}  // namespace rali::host
