#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace rali::host {

/// Quantiles of the newest thousand durations, and the maximum of all.
class DurationStats {
 public:
  void add(double value_s) {
    if (recent_s_.size() < kRecent) {
      recent_s_.push_back(value_s);
    } else {
      recent_s_[next_] = value_s;
      next_ = (next_ + 1) % kRecent;
    }
    max_s_ = std::max(max_s_, value_s);
    ++count_;
  }

  /// 0 without any. @param q 0 to 1
  [[nodiscard]] double quantile_s(double q) const {
    if (recent_s_.empty()) return 0.0;
    std::vector<double> sorted = recent_s_;
    const auto last = static_cast<double>(sorted.size() - 1);
    const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(q * last + 0.5);
    std::nth_element(sorted.begin(), at, sorted.end());
    return *at;
  }

  [[nodiscard]] double max_s() const { return max_s_; }

  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  static constexpr std::size_t kRecent = 1000;
  std::vector<double> recent_s_;
  std::size_t next_ = 0, count_ = 0;
  double max_s_ = 0.0;
};

}  // namespace rali::host
