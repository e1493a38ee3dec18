#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace rali::report {

/// A span of values; empty() until something finite was added.
class Range {
 public:
  void add(double value);

  [[nodiscard]] bool empty() const { return !(low_ <= high_); }

  [[nodiscard]] double low() const { return empty() ? 0.0 : low_; }

  [[nodiscard]] double high() const { return empty() ? 1.0 : high_; }

  [[nodiscard]] double width() const { return high() - low(); }

  /// Wider by a share on both sides, at least `least` wide.
  [[nodiscard]] Range widened(double share, double least) const;

 private:
  double low_ = 1.0, high_ = 0.0;
  bool any_ = false;
};

/// Round numbers (1, 2, 5 times a power of ten) within the range, about `count` of them.
[[nodiscard]] std::vector<double> ticks_of(const Range& range, std::size_t count);

/// The step between such ticks.
[[nodiscard]] double tick_step(double width, std::size_t count);

/// A tick's number with as many decimals as its step needs.
[[nodiscard]] std::string tick_text(double value, double step);

}  // namespace rali::report
