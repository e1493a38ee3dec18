#pragma once

#include <span>

namespace rali::degeneracy {

/// What a detector said about one scan and what was true.
struct Judged {
  double score = 0.0;  ///< low = blind; may be infinite, not NaN
  bool blind = false;  ///< the truth
};

/// How well scores separate, whatever the threshold.
struct Roc {
  int blind = 0, seen = 0;
  double auc = 0.0;       ///< 1: always right, 0.5: coin, 0: always wrong; equal scores count half
  double hit_at_5 = 0.0;  ///< share of the blind found where at most 5 % of the seen are called so
  double best_score = 0.0;  ///< threshold with the best mean of hit and 1 - false
};

/// Shares at one threshold: blind if score < threshold.
struct Rates {
  double hit = 0.0;          ///< of the blind
  double false_alarm = 0.0;  ///< of the seen
};

/// With no blind or no seen scan the areas and shares are 0.
[[nodiscard]] Roc roc_of(std::span<const Judged> scans);

[[nodiscard]] Rates rates_at(std::span<const Judged> scans, double threshold);

}  // namespace rali::degeneracy
