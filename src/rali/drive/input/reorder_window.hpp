#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// Sorts events by stamp within a window of data time: an event leaves when one that is younger by
/// the window has arrived. Later arrivals are dropped and counted. Equal stamps keep the order
/// inertial sample, range, scan, then the order of arrival.
class ReorderWindow {
 public:
  explicit ReorderWindow(Duration window = Duration::from_ns(500'000'000)) : window_(window) {}

  /// @param t stamp of the event: for a scan the time of its last point, since it cannot be
  /// processed earlier.
  /// @return false: later than the window, dropped.
  bool push(Time t, vehicle::Event event);

  /// The oldest event, if it is ready.
  [[nodiscard]] std::optional<std::pair<Time, vehicle::Event>> pop();

  /// No more events will come: all become ready.
  void finish() { finished_ = true; }

  [[nodiscard]] std::uint64_t late() const { return late_; }

  [[nodiscard]] std::size_t waiting() const { return heap_.size(); }

 private:
  struct Entry {
    Time t;
    int rank;
    std::uint64_t order;
    vehicle::Event event;
  };

  struct Later {
    bool operator()(const Entry& a, const Entry& b) const {
      if (a.t != b.t) return a.t > b.t;
      if (a.rank != b.rank) return a.rank > b.rank;
      return a.order > b.order;
    }
  };

  Duration window_;
  std::vector<Entry> heap_;
  std::optional<Time> newest_, left_;
  std::uint64_t order_ = 0, late_ = 0;
  bool finished_ = false;
};

}  // namespace rali::drive
