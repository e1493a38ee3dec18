#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rali/report/numbers.hpp"

namespace rali::report {

/// How a range was used; column `reason`. kOther: a word unknown to this version.
enum class RangeOutcome : std::uint8_t {
  kUsed,
  kNlos,
  kOutlier,
  kBlockedByGate,
  kOutOfLimits,
  kNoPose,
  kDuplicate,
  kLate,
  kUnknownId,
  kNotNeeded,
  kBadGeometry,
  kOther
};
inline constexpr std::size_t kRangeOutcomeCount = 12;

/// As plain text for users.
[[nodiscard]] std::string_view outcome_words(RangeOutcome outcome);

/// Meaning of a word of ranges.csv; for unknown words `used` decides.
[[nodiscard]] RangeOutcome outcome_of(std::string_view reason, bool used);

/// One range, or several that are too close to be distinguished in a drawing.
struct RangeDot {
  double t_s = 0.0;
  double residual_m = kUnknown;
};

/// All ranges between two vehicles, in either direction.
struct PairRanges {
  std::string a, b;                                            ///< in alphabetical order
  std::array<std::size_t, kRangeOutcomeCount> count{};         ///< rows
  std::array<std::vector<RangeDot>, kRangeOutcomeCount> dots;  ///< thinned, by time
  double bias_m = kUnknown;                                    ///< the last one
  double residual_std_m = kUnknown;                            ///< of the ranges used

  [[nodiscard]] std::size_t total() const;

  [[nodiscard]] std::size_t used() const { return count[0]; }
};

/// Ranges received by a vehicle in a period of time.
struct Received {
  double start_s = 0.0, end_s = 0.0;
  std::size_t used = 0, rejected = 0;
};

struct RangeTable {
  bool known = false;  ///< ranges.csv exists
  std::size_t rows = 0;
  std::array<std::size_t, kRangeOutcomeCount> count{};
  std::vector<PairRanges> pairs;            ///< of the vehicles of the run, by name
  std::size_t strangers = 0;                ///< rows with an end that is no vehicle of the run
  std::vector<std::string> stranger_names;  ///< the first few
  std::vector<std::string> other_reasons;   ///< words behind kOther, the first few
};

}  // namespace rali::report
