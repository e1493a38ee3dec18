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
  for (const Judged& s : sorted) ++(s.blind ? out.blind : out.seen);
  if (out.blind == 0 || out.seen == 0) return out;
  double pairs = 0.0;  // blind below seen, ties half
  double best = -1.0;
  int hits = 0;
  int falses = 0;
  for (std::size_t i = 0; i < sorted.size();) {
    std::size_t end = i;
    int blind = 0;
    while (end < sorted.size() && sorted[end].score == sorted[i].score) {
      blind += sorted[end++].blind ? 1 : 0;
    }
    const int seen = static_cast<int>(end - i) - blind;
    pairs += seen * (hits + 0.5 * blind);
    hits += blind;
    falses += seen;
    const double hit = static_cast<double>(hits) / out.blind;
    const double wrong = static_cast<double>(falses) / out.seen;
    if (wrong <= 0.05) out.hit_at_5 = hit;
    if (hit - wrong > best) {
      best = hit - wrong;
      out.best_score =
          end < sorted.size() ? sorted[end].score : std::numeric_limits<double>::infinity();
    }
    i = end;
  }
  out.auc = pairs / (static_cast<double>(out.blind) * out.seen);
  return out;
}

Rates rates_at(std::span<const Judged> scans, double threshold) {
  int blind = 0;
  int hits = 0;
  int falses = 0;
  for (const Judged& s : scans) {
    blind += s.blind ? 1 : 0;
    if (s.score < threshold) ++(s.blind ? hits : falses);
  }
  const int seen = static_cast<int>(scans.size()) - blind;
  return {blind > 0 ? static_cast<double>(hits) / blind : 0.0,
          seen > 0 ? static_cast<double>(falses) / seen : 0.0};
}

}  // namespace rali::degeneracy
