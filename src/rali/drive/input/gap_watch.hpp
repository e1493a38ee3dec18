#pragma once

#include <optional>
#include <string>

#include "rali/drive/input/input_report.hpp"

namespace rali::drive {

/// Counts the gaps in one stream of outgoing events by the steps of its stamps.
class GapWatch {
 public:
  /// @param factor a step of more than this many periods is a gap
  /// @param min_s minimum length of a gap
  GapWatch(double factor, double min_s) : factor_(factor), min_s_(min_s) {}

  void see(Time t);

  [[nodiscard]] std::uint64_t gaps() const { return gaps_; }

  [[nodiscard]] double missing_s() const { return missing_s_; }

  [[nodiscard]] double longest_s() const { return longest_s_; }

  [[nodiscard]] Time t_longest() const { return t_longest_; }

  /// Typical step [s], 0 before the third event.
  [[nodiscard]] double period_s() const { return period_s_; }

 private:
  double factor_, min_s_;
  std::optional<Time> last_;
  double period_s_ = 0.0;
  std::uint64_t gaps_ = 0;
  double missing_s_ = 0.0, longest_s_ = 0.0;
  Time t_longest_;
};

/// The finding D01 (scans) or D10 (inertial samples) about missing data; empty if none is missing.
[[nodiscard]] std::optional<Finding> gap_finding(const GapWatch& watch, const std::string& id,
                                                 const std::string& what);

}  // namespace rali::drive
