#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// A device's count of milliseconds in 32 bits, which starts again at 0 after 49.7 days, as a time
/// that does not. A step of more than half of that counts as backward.
class MillisecondCount {
 public:
  [[nodiscard]] Duration unwrap(std::uint32_t count_ms);

 private:
  std::optional<std::uint32_t> last_ms_;
  std::int64_t total_ms_ = 0;
};

/// When a device's stamp was on the host's clock, from when its messages arrived (algorithms 4.6).
///
/// A message is never early: arrival less device time is the offset of the clocks plus a delay that
/// is not negative. So the line below all such points is sought, not the one through them: the
/// lower convex hull of the last `window_s`, of it the edge under the mean of the times (which has
/// the least sum of delays above it), its slope within the drift that clocks can have. The line is
/// extended forward to the newest stamp, so each answer uses only what came before. The very newest
/// edge would not do: its end is the newest message, whatever its delay.
///
/// A constant delay is not seen by this and remains; it belongs into the time offset of the radio.
///
/// If the device's clock runs backward or jumps forward it starts anew; messages that come too late
/// are believed to be late until there are `restart_count` of them in a row.
class ArrivalClock {
 public:
  explicit ArrivalClock(const ArrivalClockSettings& settings);

  /// The next message: its stamp on the device's clock and when it arrived. Returns when the stamp
  /// was, on the host's clock; never later than the arrival but by the rounding of a double.
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
