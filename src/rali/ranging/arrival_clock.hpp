#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// Unwraps a device's count of milliseconds in 32 bits, which starts again at 0 after 49.7 days. A
/// step of more than half of that counts as backward.
class MillisecondCount {
 public:
  [[nodiscard]] Duration unwrap(std::uint32_t count_ms);

 private:
  std::optional<std::uint32_t> last_ms_;
  std::int64_t total_ms_ = 0;
};

/// Converts a device's stamps to the host's clock, by the arrival of its messages (algorithms 4.6).
///
/// Arrival less device time is the offset of the clocks plus a delay that is never negative. So the
/// line is fitted below all such points, not through them. It is the edge of the lower convex hull
/// of the last `window_s` under the mean of the times, which has the least sum of delays above it.
/// Its slope is limited to the drift that clocks can have. The line is extrapolated to the newest
/// stamp, so each answer uses only earlier messages. The newest edge would not do: its end is the
/// newest message, whatever its delay.
///
/// A constant delay is not observable and remains; it belongs in the time offset of the radio.
///
/// If the device's clock runs backward or jumps forward, the estimate restarts. Late messages count
/// as delayed; `restart_count` of them in a row restart it, too.
class ArrivalClock {
 public:
  explicit ArrivalClock(const ArrivalClockSettings& settings);

  /// Adds the next message: its stamp on the device's clock and its arrival. Returns the stamp on
  /// the host's clock; never later than the arrival but by the rounding of a double.
  Time add(Duration device, Time arrival);

  /// Host time of a stamp; nothing before the first message.
  [[nodiscard]] std::optional<Time> host_time(Duration device) const;

  [[nodiscard]] int restarts() const { return restarts_; }

 private:
  struct Point {
    double x_s, y_s;  ///< device time and arrival less device time, both less those of the first
  };

  void start(Duration device, Time arrival);
  [[nodiscard]] Point point_of(Duration device, Time arrival) const;

  [[nodiscard]] double offset_at(double x_s) const { return level_s_ + slope_ * x_s; }

  [[nodiscard]] bool must_restart(const Point& p);
  void add_to_hull(const Point& p);
  void forget_old();
  void find_line();

  ArrivalClockSettings settings_;
  bool started_ = false;
  Duration device_0_;
  Time arrival_0_;
  std::vector<Point> points_;
  std::vector<Point> hull_;  ///< lower hull of points_, left to right
  double sum_x_s_ = 0.0;     ///< of points_
  double level_s_ = 0.0, slope_ = 0.0;
  int late_ = 0;
  int restarts_ = 0;
};

}  // namespace rali::ranging
