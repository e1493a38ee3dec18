#include "rali/drive/closed_loop/simulated_jobs.hpp"

#include <algorithm>
#include <atomic>
#include <ctime>
#include <utility>

namespace rali::drive {

Duration JobCost::of(fleet::JobKind kind, const fleet::JobWork& work) const {
  const double start_s = fleet::explores(kind) ? 0.0 : job_s;
  return Duration::from_s(start_s + node_s * static_cast<double>(work.nodes) +
                          submap_s * static_cast<double>(work.submaps) +
                          compared_s * static_cast<double>(work.compared) +
                          cell_drawn_s * static_cast<double>(work.cells_drawn) +
                          cell_searched_s * static_cast<double>(work.cells_searched));
}

void SimulatedJobs::run(std::size_t owner, const fleet::RunJob& order, Time now,
                        Executor& executor) {
  const std::atomic<bool> never = false;
  const std::clock_t begin = std::clock();
  order.job->run(executor, never);
  const double cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  spent_.push_back({order.kind, order.job->work(), cpu_s});
  const double duration_s = computer_.cpu_factor * cost_.of(order.kind, order.job->work()).s();
  under_way_.push_back({now + Duration::from_s(duration_s), {owner, {order.number, order.job}}});
}

void SimulatedJobs::cancel(std::size_t owner, std::uint64_t number, Time now) {
  for (Entry& entry : under_way_) {
    if (entry.done.owner == owner && entry.done.event.number == number) {
      entry.due = std::min(entry.due, now);
    }
  }
}

void SimulatedJobs::forget(std::size_t owner) {
  std::erase_if(under_way_, [owner](const Entry& e) { return e.done.owner == owner; });
}

std::vector<SimulatedJobs::Done> SimulatedJobs::take(Time now) {
  const auto ended = std::stable_partition(under_way_.begin(), under_way_.end(),
                                           [now](const Entry& e) { return e.due > now; });
  std::stable_sort(ended, under_way_.end(),
                   [](const Entry& a, const Entry& b) { return a.due < b.due; });
  std::vector<Done> out;
  for (auto entry = ended; entry != under_way_.end(); ++entry)
    out.push_back(std::move(entry->done));
  under_way_.erase(ended, under_way_.end());
  return out;
}

}  // namespace rali::drive
