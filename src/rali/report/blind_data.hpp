#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "rali/report/numbers.hpp"

namespace rali::report {

/// What kept a pose along its least known direction; column `held_by`, the better first.
enum class HeldBy : std::uint8_t { kLidar, kRange, kImu, kNothing };
inline constexpr std::size_t kHeldByCount = 4;

/// How much one sweep tells along its worst direction; column `category`, the better first.
enum class Sight : std::uint8_t { kFull, kPartial, kNone };

/// One row of degeneracy/<v>.csv. Files of older versions have no `category`, `sigma_m`, `held_by`:
/// then the class follows from `blind`, and what no range held was held by nothing.
struct DegeneracyPoint {
  double t_s = 0.0;
  double degree = kUnknown;  ///< lambda2/lambda3 of the paper
  geometry::Vec3 axis = geometry::Vec3::Constant(kUnknown);
  double sigma_blind_m = kUnknown;
  double off_m = kUnknown;       ///< expected error of the final pose along `axis`, 1 sigma
  std::uint16_t range_from = 0;  ///< place in BlindWay::range_names, from 1; 0: no range held it
  bool blind = false;
  Sight sight = Sight::kFull;
  HeldBy held_by = HeldBy::kLidar;
};

/// A stretch of time on which the vehicle was blind.
struct BlindSpan {
  double begin_s = 0.0, end_s = 0.0;
  geometry::Vec3 axis = geometry::Vec3::Zero();  ///< mean, one sign
  double way_m = 0.0;
  double along_way = kUnknown;  ///< mean |cos| of the angle between axis and motion
  double off_begin_m = kUnknown, off_max_m = kUnknown;  ///< expected along the axis, 1 sigma
  std::array<double, kHeldByCount> held_share{};        ///< of its sweeps, by HeldBy
  std::string held_by;  ///< vehicles whose ranges held it, with commas; empty: none
};

/// Length in metres of the way and in seconds.
struct WayShare {
  double m = 0.0, s = 0.0;

  void add(const WayShare& step) { m += step.m, s += step.s; }
};

/// The largest expected error along the blind axis and when it was.
struct OffPeak {
  double off_m = kUnknown, t_s = kUnknown;

  void see(double value_m, double at_s);
};

/// How much of a vehicle's way was blind and what held it there, summed over its sweeps. A step of
/// the way belongs to the sweep at its end, as in metrics.json.
struct BlindWay {
  bool known = false;  ///< there is a degeneracy file
  WayShare all, blind;
  std::array<WayShare, kHeldByCount> held;  ///< parts of `blind`, by HeldBy
  OffPeak peak, peak_nothing;               ///< of all blind sweeps; of those that nothing held
  WayShare unheard;                         ///< part of `blind` with no range heard within 2 s
  std::vector<std::string> range_names;     ///< vehicles whose ranges held it
};

}  // namespace rali::report
