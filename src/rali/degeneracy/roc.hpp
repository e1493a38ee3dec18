#pragma once

#include <span>

namespace rali::degeneracy {

/// A detector's score for one scan, and the ground truth.
struct Judged {
  double score = 0.0;       ///< low = degenerate; may be infinite, not NaN
  bool degenerate = false;  ///< ground truth
};

/// How well the scores separate degenerate from observable scans, over all thresholds.
struct Roc {
  int degenerate = 0, seen = 0;
  double auc = 0.0;  ///< 1: always right, 0.5: chance, 0: always wrong; equal scores count half
  double hit_at_5 = 0.0;    ///< hit rate with at most 5 % false alarms
  double best_score = 0.0;  ///< threshold with the best mean of hit and 1 - false
};

/// Rates at one threshold: a scan is called degenerate if score < threshold.
struct Rates {
  double hit = 0.0;          ///< fraction of the degenerate scans
  double false_alarm = 0.0;  ///< fraction of the observable scans
};

/// Without degenerate scans, or without observable ones, areas and rates are 0.
[[nodiscard]] Roc roc_of(std::span<const Judged> scans);

[[nodiscard]] Rates rates_at(std::span<const Judged> scans, double threshold);

}  // namespace rali::degeneracy
