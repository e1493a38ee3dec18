#include "rali/drive/read_ahead.hpp"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace rali::drive {
namespace {

using Item = Result<std::optional<vehicle::Event>>;

bool is_scan(const Item& item) {
  return item && *item && std::holds_alternative<std::shared_ptr<const sensor::LidarScan>>(**item);
}

/// A sensor that sends only inertial data must not fill the memory either.
constexpr std::size_t kItems = 20000;

bool is_last(const Item& item) { return !item || !*item; }

}  // namespace

class ReadAhead::Queue {
 public:
  explicit Queue(EventSource& source) : source_(source), thread_([this] { fill(); }) {}

  ~Queue() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  std::pair<Item, double> take() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !items_.empty() || fault_; });
    if (items_.empty()) std::rethrow_exception(fault_);
    std::pair<Item, double> front = std::move(items_.front());
    // The end stays in the queue: further calls return the end again.
    if (is_last(front.first)) {
      items_.front() = front;
      return front;
    }
    items_.pop_front();
    if (is_scan(front.first)) --scans_;
    lock.unlock();
    changed_.notify_all();
    return front;
  }

 private:
  void fill() {
    try {
      while (true) {
        Item item = source_.next();
        const double progress = source_.progress();
        const bool last = is_last(item);
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] {
          return stop_ || items_.empty() || (scans_ < kScans && items_.size() < kItems);
        });
        if (stop_) return;
        if (is_scan(item)) ++scans_;
        items_.emplace_back(std::move(item), progress);
        lock.unlock();
        changed_.notify_all();
        if (last) return;
      }
    } catch (...) {
      // An internal assertion: passed to the thread whose caller catches it.
      const std::lock_guard lock(mutex_);
      fault_ = std::current_exception();
      changed_.notify_all();
    }
  }

  EventSource& source_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::pair<Item, double>> items_;
  std::size_t scans_ = 0;
  bool stop_ = false;
  std::exception_ptr fault_;
  std::thread thread_;
};

ReadAhead::ReadAhead(EventSource& source) : queue_(std::make_unique<Queue>(source)) {}

ReadAhead::~ReadAhead() = default;

Result<std::optional<vehicle::Event>> ReadAhead::next() {
  auto [item, progress] = queue_->take();
  progress_ = progress;
  return std::move(item);
}

double ReadAhead::progress() const { return progress_; }

}  // namespace rali::drive
