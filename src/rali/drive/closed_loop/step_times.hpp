#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "rali/fleet/node/events.hpp"

namespace rali::drive {

/// Durations of one kind of step, in a histogram whose bins grow by a tenth: 1 us to 100 s.
class TimeHistogram {
 public:
  void add(double s);

  [[nodiscard]] std::uint64_t count() const { return count_; }

  /// The time below which this fraction of the steps lies, to a tenth; 0 without any.
  [[nodiscard]] double quantile_s(double fraction) const;

  [[nodiscard]] double max_s() const { return max_s_; }

 private:
  static constexpr std::size_t kBins = 194;  ///< ln(1e8) / ln(1.1)

  std::array<std::uint64_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  double max_s_ = 0.0;
};

/// How long nodes take for their steps, by kind of event. The limit is 2 ms (architecture.md 4).
/// Measures CPU time of the thread: a step waits for nothing, and other load on the machine must
/// not count. Not part of a run's results: two equal runs differ in it.
class StepTimes {
 public:
  void add(const fleet::NodeEvent& event, double s);

  /// CPU time of the calling thread [s], from an arbitrary origin.
  [[nodiscard]] static double thread_s();

  struct Row {
    std::string_view event;
    const TimeHistogram* times = nullptr;
  };

  /// One row for each kind of event that occurred.
  [[nodiscard]] std::vector<Row> rows() const;

  /// "tick: 1200 steps, p50 0.02 ms, p99.9 1.1 ms, max 1.3 ms", one line for each kind.
  [[nodiscard]] std::vector<std::string> lines() const;

 private:
  std::map<std::string_view, TimeHistogram> kinds_;
};

}  // namespace rali::drive
