#include "rali/host/job_worker.hpp"

#include <algorithm>
#include <utility>

#include "rali/host/host_clock.hpp"

namespace rali::host {
namespace {

constexpr Duration kOrderWait = Duration::from_ns(50'000'000);

}  // namespace

JobWorker::JobWorker(std::unique_ptr<Executor> executor)
    : executor_(std::move(executor)), thread_([this] { loop(); }) {}

JobWorker::~JobWorker() {
  end_.store(true, std::memory_order_release);
  {
    const std::lock_guard lock(mutex_);
    for (auto& [number, flag] : flags_) flag->store(true);
  }
  thread_.join();
}

void JobWorker::run(std::uint64_t number, std::shared_ptr<fleet::Job> job) {
  {
    const std::lock_guard lock(mutex_);
    flags_[number] = std::make_shared<std::atomic<bool>>(false);
  }
  if (orders_.put({number, std::move(job)})) return;
  done_.put(fleet::JobDone{number, nullptr});  // as a lost job: the node makes another
  const std::lock_guard lock(mutex_);
  flags_.erase(number);
}

void JobWorker::cancel(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  const auto flag = flags_.find(number);
  if (flag != flags_.end()) flag->second->store(true);
}

void JobWorker::loop() {
  while (!end_.load(std::memory_order_acquire)) {
    for (fleet::JobDone& order : orders_.take(kOrderWait)) {
      std::shared_ptr<std::atomic<bool>> flag;
      {
        const std::lock_guard lock(mutex_);
        flag = flags_[order.number];
      }
      const Time begin = host_now().boot;
      if (!end_.load(std::memory_order_acquire)) order.job->run(*executor_, *flag);
      const double took_s = seconds_between(begin, host_now().boot);
      longest_s_.store(std::max(longest_s(), took_s), std::memory_order_relaxed);
      {
        const std::lock_guard lock(mutex_);
        flags_.erase(order.number);
      }
      done_.put(std::move(order));
    }
  }
}

}  // namespace rali::host
