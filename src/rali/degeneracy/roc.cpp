#include "rali/degeneracy/roc.hpp"

#include <algorithm>
#include <limits>
#include <vector>

namespace rali::degeneracy {

Roc roc_of(std::span<const Judged> scans) {
  std::vector<Judged> sorted(scans.begin(), scans.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Judged& a, const Judged& b) { return a.score < b.score; });
  Roc out;
  for (const Judged& s : sorted) ++(s.degenerate ? out.degenerate : out.seen);
  if (out.degenerate == 0 || out.seen == 0) return out;
  double pairs = 0.0;  // pairs with the degenerate scan below the observable one, ties half
  double best = -1.0;
  int hits = 0;
  int falses = 0;
  for (std::size_t i = 0; i < sorted.size();) {
    std::size_t end = i;
    int degenerate = 0;
    while (end < sorted.size() && sorted[end].score == sorted[i].score) {
      degenerate += sorted[end++].degenerate ? 1 : 0;
    }
    const int seen = static_cast<int>(end - i) - degenerate;
    pairs += seen * (hits + 0.5 * degenerate);
    hits += degenerate;
    falses += seen;
    const double hit = static_cast<double>(hits) / out.degenerate;
    const double wrong = static_cast<double>(falses) / out.seen;
    if (wrong <= 0.05) out.hit_at_5 = hit;
    if (hit - wrong > best) {
      best = hit - wrong;
      out.best_score =
          end < sorted.size() ? sorted[end].score : std::numeric_limits<double>::infinity();
    }
    i = end;
  }
  out.auc = pairs / (static_cast<double>(out.degenerate) * out.seen);
  return out;
}

Rates rates_at(std::span<const Judged> scans, double threshold) {
  int degenerate = 0;
  int hits = 0;
  int falses = 0;
  for (const Judged& s : scans) {
    degenerate += s.degenerate ? 1 : 0;
    if (s.score < threshold) ++(s.degenerate ? hits : falses);
  }
  const int seen = static_cast<int>(scans.size()) - degenerate;
  return {degenerate > 0 ? static_cast<double>(hits) / degenerate : 0.0,
          seen > 0 ? static_cast<double>(falses) / seen : 0.0};
}

}  // namespace rali::degeneracy
