#pragma once

#include <cmath>
#include <compare>
#include <cstdint>
#include <limits>

namespace rali {

/// A span of time in whole nanoseconds.
struct Duration {
  std::int64_t ns = 0;

  [[nodiscard]] static constexpr Duration from_ns(std::int64_t value) { return {value}; }

  /// Seconds to nanoseconds, rounded; not-a-number gives 0, values out of range are clamped.
  [[nodiscard]] static Duration from_s(double value_s) {
    constexpr double kLimit = 9.2e18;
    const double value = value_s * 1e9;
    if (!(value == value)) return {0};
    if (value >= kLimit) return {std::numeric_limits<std::int64_t>::max()};
    if (value <= -kLimit) return {std::numeric_limits<std::int64_t>::min()};
    return {std::llround(value)};
  }

  [[nodiscard]] constexpr double s() const { return static_cast<double>(ns) * 1e-9; }

  constexpr auto operator<=>(const Duration&) const = default;

  constexpr Duration operator-() const { return {-ns}; }

  constexpr Duration operator+(Duration o) const { return {ns + o.ns}; }

  constexpr Duration operator-(Duration o) const { return {ns - o.ns}; }
};

/// A point in time of the vehicle's or fleet's clock: int64 nanoseconds, because a double of
/// seconds since 1970 has steps of 238 ns.
struct Time {
  std::int64_t ns = 0;

  [[nodiscard]] static constexpr Time from_ns(std::int64_t value) { return {value}; }

  [[nodiscard]] static Time from_s(double value_s) { return {Duration::from_s(value_s).ns}; }

  /// Seconds; for printing and for differences only.
  [[nodiscard]] constexpr double s() const { return static_cast<double>(ns) * 1e-9; }

  constexpr auto operator<=>(const Time&) const = default;

  constexpr Time operator+(Duration d) const { return {ns + d.ns}; }

  constexpr Time operator-(Duration d) const { return {ns - d.ns}; }

  constexpr Duration operator-(Time o) const { return {ns - o.ns}; }
};

/// (a - b) in seconds.
[[nodiscard]] constexpr double seconds_between(Time b, Time a) { return (a - b).s(); }

}  // namespace rali
