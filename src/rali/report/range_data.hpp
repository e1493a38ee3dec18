#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rali/report/numbers.hpp"

namespace rali::report {

/// What became of a range; column `reason`. kOther: a word that this version does not know.
enum class RangeFate : std::uint8_t {
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
inline constexpr std::size_t kRangeFateCount = 12;

/// The word of ranges.csv and of metrics.json; "other" for what is not known.
[[nodiscard]] std::string_view fate_name(RangeFate fate);

/// In words, plain text.
[[nodiscard]] std::string_view fate_words(RangeFate fate);

/// What a word of ranges.csv means; `used` decides where the word does not.
[[nodiscard]] RangeFate fate_of(std::string_view reason, bool used);

/// A range or several that lie too near to each other to be told apart in a drawing.
struct RangeDot {
  double t_s = 0.0;
  double residual_m = kUnknown;
};

/// All ranges between two vehicles, in either direction.
struct PairRanges {
  std::string a, b;                                         ///< in the order of the alphabet
  std::array<std::size_t, kRangeFateCount> count{};         ///< rows
  std::array<std::vector<RangeDot>, kRangeFateCount> dots;  ///< thinned, by time
  double bias_m = kUnknown;                                 ///< the last one
  double residual_std_m = kUnknown;                         ///< of the ranges used

  [[nodiscard]] std::size_t total() const;

  [[nodiscard]] std::size_t used() const { return count[0]; }
};

/// Ranges heard by a vehicle in a span of time.
struct Heard {
  double begin_s = 0.0, end_s = 0.0;
  std::size_t used = 0, rejected = 0;
};

struct RangeTable {
  bool known = false;  ///< there is a ranges.csv
  std::size_t rows = 0;
  std::array<std::size_t, kRangeFateCount> count{};
  std::vector<PairRanges> pairs;            ///< of the vehicles of the run, by name
  std::size_t strangers = 0;                ///< rows of which an end is no vehicle of the run
  std::vector<std::string> stranger_names;  ///< the first few
  std::vector<std::string> other_reasons;   ///< words behind kOther, the first few
};

}  // namespace rali::report
