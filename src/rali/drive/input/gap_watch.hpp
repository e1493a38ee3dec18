#pragma once

#include <optional>
#include <string>

#include "rali/drive/input/input_report.hpp"

namespace rali::drive {

/// Counts what one stream of the events that leave lacks: watches the steps of its stamps.
class GapWatch {
 public:
  /// @param factor a step of more than so many periods is a gap
  /// @param least_s and at least so long
  GapWatch(double factor, double least_s) : factor_(factor), least_s_(least_s) {}

  void see(Time t);

  [[nodiscard]] std::uint64_t gaps() const { return gaps_; }

  [[nodiscard]] double missing_s() const { return missing_s_; }

  [[nodiscard]] double longest_s() const { return longest_s_; }

  [[nodiscard]] Time t_longest() const { return t_longest_; }

  /// Usual step [s], 0 before the third event.
  [[nodiscard]] double period_s() const { return period_s_; }

 private:
  double factor_, least_s_;
  std::optional<Time> last_;
  double period_s_ = 0.0;
  std::uint64_t gaps_ = 0;
  double missing_s_ = 0.0, longest_s_ = 0.0;
  Time t_longest_;
};

/// The finding D01 (sweeps) or D10 (inertial samples) of what was missing; empty if nothing was.
[[nodiscard]] std::optional<Finding> gap_finding(const GapWatch& watch, const std::string& id,
                                                 const std::string& what);

}  // namespace rali::drive
