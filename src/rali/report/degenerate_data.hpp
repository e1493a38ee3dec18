#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "rali/report/numbers.hpp"

namespace rali::report {

/// What constrained a pose along its least observable direction; column `constrained_by`, best
/// first.
enum class HeldBy : std::uint8_t { kLidar, kRange, kImu, kNothing };
inline constexpr std::size_t kHeldByCount = 4;

/// Observability of one scan along its worst direction; column `category`, best first.
enum class Sight : std::uint8_t { kFull, kPartial, kNone };

/// One row of degeneracy/<v>.csv. Files of older versions lack `category`, `sigma_m`,
/// `constrained_by`. Then `degenerate` gives the class, and a degenerate pose without a range
/// counts as unconstrained.
struct DegeneracyPoint {
  double t_s = 0.0;
  double degree = kUnknown;  ///< lambda2/lambda3 of the paper
  geometry::Vec3 axis = geometry::Vec3::Constant(kUnknown);
  double sigma_degenerate_m = kUnknown;
  double off_m = kUnknown;  ///< expected error of the final pose along `axis`, 1 sigma
  std::uint16_t range_from =
      0;  ///< position in DegeneratePath::range_names, from 1; 0: no range constrained it
  bool degenerate = false;
  Sight sight = Sight::kFull;
  HeldBy held_by = HeldBy::kLidar;
};

/// A period in which the vehicle was degenerate.
struct DegenerateSpan {
  double start_s = 0.0, end_s = 0.0;
  geometry::Vec3 axis = geometry::Vec3::Zero();  ///< mean, one sign
  double path_m = 0.0;
  double along_path = kUnknown;  ///< mean |cos| of the angle between axis and motion
  double off_start_m = kUnknown, off_max_m = kUnknown;  ///< expected along the axis, 1 sigma
  std::array<double, kHeldByCount> held_fraction{};     ///< of its scans, by HeldBy
  std::string held_by;  ///< vehicles whose ranges constrained it, with commas; empty: none
};

/// A length in metres of distance travelled and in seconds.
struct PathFraction {
  double m = 0.0, s = 0.0;

  void add(const PathFraction& step) { m += step.m, s += step.s; }
};

/// The largest expected error along the degenerate axis and its time.
struct OffPeak {
  double off_m = kUnknown, t_s = kUnknown;

  void see(double value_m, double at_s);
};

/// The degenerate part of a vehicle's trajectory and what constrained it there, summed over its
/// scans. A step of the trajectory belongs to the scan at its end, as in metrics.json.
struct DegeneratePath {
  bool known = false;  ///< there is a degeneracy file
  PathFraction all, degenerate;
  std::array<PathFraction, kHeldByCount> held;  ///< parts of `degenerate`, by HeldBy
  OffPeak peak, peak_nothing;                   ///< of all degenerate scans; of the unconstrained
                                                ///< ones
  PathFraction without_range;            ///< part of `degenerate` with no range received within 2 s
  std::vector<std::string> range_names;  ///< vehicles whose ranges constrained it
};

}  // namespace rali::report
