#pragma once

#include <array>
#include <string>
#include <vector>

#include "pair_data.hpp"
#include "rali/ranging/range_use.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranges_bench {

/// Prior knowledge of the estimator without ranges.
struct ChainOptions {
  /// Sd of the error of the predicted distance; the error is drawn with it and the filter uses it.
  double position_sigma_m = 0.05;
  double speed_sigma_mps = 0.04;  ///< of the range rate; about that of the vehicle's filter
  double drift_m_rts = 0.03;  ///< how fast that error changes
  ranging::RangingSettings ranging;
};

/// Results for the ranges of a set. "Bad": error minus the pair's median is beyond 0.3 m.
struct ChainScores {
  std::size_t pairs = 0, ranges = 0;
  std::size_t bad = 0, bad_refused = 0;
  std::size_t good = 0, good_kept = 0;
  std::size_t gross = 0, gross_refused = 0;  ///< bad ones beyond 1 m
  std::array<std::size_t, ranging::kRangeReasonNames.size()> reasons{};
  std::size_t widened = 0;  ///< times that the link or the excess detector widened the pose
  double square_before_m2 = 0.0;
  double square_after = 0.0, weight_after = 0.0;  ///< squared errors by inverse variance used
  double offset_square_m2 = 0.0;                  ///< of the tracked offset
  double nees_offset = 0.0, nees_distance = 0.0;  ///< sums
  std::size_t offset_in_95 = 0;

  void add(const ChainScores& other);
};

/// Runs the ranges of one pair through module `ranging` as the vehicle's range stage does: sanity,
/// signal, excess, gate and link, thinning, and a filter with two states, error of the predicted
/// distance and bias of the pair. Walls are unknown without a map.
[[nodiscard]] ChainScores run_chain(const PairRecord& pair, std::uint64_t seed,
                                    const ChainOptions& options);

[[nodiscard]] ChainScores run_chain(const PairSet& set, const ChainOptions& options);

/// A Markdown table of all sets, four rows each, and one of the reasons.
[[nodiscard]] std::string pair_tables(const std::vector<PairSet>& sets);

}  // namespace rali::ranges_bench
