#include "rali/fleet/centre/loop_search.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <tuple>

namespace rali::fleet {

namespace {

/// Pieces of one path overlap while the vehicle passes a place: that is no loop.
bool may_be_loop(const PathSubmap& a, const PathSubmap& b, double apart_m) {
  return a.path != b.path || std::abs(a.path_m - b.path_m) >= apart_m;
}

/// A candidate, and its rank among those of its source.
struct Ranked {
  std::size_t target = 0;  ///< number along its path
  std::size_t rank = 0;
  double score = 0.0;
  LoopCandidate candidate;
};

/// Similarity of the pieces of two paths: for each piece of the second, the most similar ones of
/// the first.
class Likenesses {
 public:
  Likenesses(std::span<const PathSubmap> submaps, std::size_t path_a, std::size_t path_b,
             const places::DescriptorSettings& settings);

  [[nodiscard]] std::size_t sources() const { return sources_.size(); }

  /// Candidates of a source, the best row first.
  [[nodiscard]] std::vector<Ranked> ranked(std::size_t b, int row) const;

 private:
  using Targets = std::map<std::size_t, double>;  ///< number of a target, and its score

  [[nodiscard]] std::vector<double> in_row(std::size_t b, int row) const;

  const places::DescriptorSettings& settings_;
  std::vector<std::size_t> targets_, sources_;  ///< submaps, along the paths
  std::vector<Targets> alike_;                  ///< per source
};

Likenesses::Likenesses(std::span<const PathSubmap> submaps, std::size_t path_a, std::size_t path_b,
                       const places::DescriptorSettings& settings)
    : settings_(settings) {
  // A neighbour counts in a row even if it would be no candidate by itself.
  places::DescriptorSettings all = settings;
  all.candidates_max = settings.key_candidates;
  all.score_min = -1.0;
  places::PlaceIndex index(all);
  std::map<KeyframeId, std::size_t> by_id;
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    if (submaps[i].path == path_b) sources_.push_back(i);
    if (submaps[i].path != path_a) continue;
    index.add(submaps[i].submap.middle(), submaps[i].descriptor);
    by_id[submaps[i].submap.middle()] = targets_.size();
    targets_.push_back(i);
  }
  const auto none = [](KeyframeId) { return false; };
  for (const std::size_t source : sources_) {
    Targets& targets = alike_.emplace_back();
    for (const places::Candidate& c : index.query(submaps[source].descriptor, none)) {
      targets[by_id.at(c.id)] = c.score;
    }
  }
}

/// Per target the mean similarity along a stretch of both paths, driven in the same or the opposite
/// direction: a chance similarity does not continue along the paths.
std::vector<double> Likenesses::in_row(std::size_t b, int row) const {
  const std::ptrdiff_t n_a = std::ssize(targets_);
  const auto before = static_cast<std::ptrdiff_t>(b);
  const std::ptrdiff_t after = std::ssize(sources_) - 1 - before;
  std::vector<double> best(targets_.size(), -1.0);
  for (const int direction : {1, -1}) {
    const std::ptrdiff_t first = -std::min<std::ptrdiff_t>(row, direction > 0 ? before : after);
    const std::ptrdiff_t last = std::min<std::ptrdiff_t>(row, direction > 0 ? after : before);
    std::vector<double> sum(targets_.size(), 0.0);
    for (std::ptrdiff_t d = first; d <= last; ++d) {
      for (const auto& [target, score] : alike_[static_cast<std::size_t>(before + direction * d)]) {
        const std::ptrdiff_t a = static_cast<std::ptrdiff_t>(target) - d;
        if (a >= 0 && a < n_a) sum[static_cast<std::size_t>(a)] += score;
      }
    }
    for (std::ptrdiff_t a = 0; a < n_a; ++a) {
      const std::ptrdiff_t n = std::min(last, n_a - 1 - a) - std::max(first, -a) + 1;
      double& of_a = best[static_cast<std::size_t>(a)];
      of_a = std::max(of_a, sum[static_cast<std::size_t>(a)] / static_cast<double>(n));
    }
  }
  return best;
}

std::vector<Ranked> Likenesses::ranked(std::size_t b, int row) const {
  std::vector<Ranked> out;
  const std::vector<double> scores = in_row(b, row);
  for (std::size_t a = 0; a < targets_.size(); ++a) {
    out.push_back({a, 0, scores[a], {targets_[a], sources_[b], std::nullopt}});
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Ranked& x, const Ranked& y) { return x.score > y.score; });
  // The best of a row is tried even with a low score of its own; others need score_min.
  const auto first = out.begin() + (out.empty() || out.front().score <= 0.0 ? 0 : 1);
  out.erase(std::remove_if(first, out.end(),
                           [&](const Ranked& r) {
                             const auto own = alike_[b].find(r.target);
                             return own == alike_[b].end() || own->second < settings_.score_min;
                           }),
            out.end());
  out.resize(std::min(out.size(), static_cast<std::size_t>(settings_.candidates_max)));
  for (std::size_t k = 0; k < out.size(); ++k) out[k].rank = k;
  return out;
}

}  // namespace

std::vector<LoopCandidate> near_candidates(std::span<const PathSubmap> submaps,
                                           const GuessOf& guess_of,
                                           const places::NearSettings& near,
                                           const LoopSettings& settings) {
  std::vector<LoopCandidate> candidates;
  for (std::size_t source = 0; source < submaps.size(); ++source) {
    // Of each earlier path, and of this one, the nearest first.
    std::map<std::size_t, std::vector<std::tuple<double, std::size_t, places::Guess>>> by_path;
    for (std::size_t target = 0; target < source; ++target) {
      if (!may_be_loop(submaps[target], submaps[source], settings.apart_m)) continue;
      const std::optional<places::Guess> guess = guess_of(target, source);
      const places::Submap& t = submaps[target].submap;
      if (!guess || !places::may_overlap(t, submaps[source].submap, *guess, near)) continue;
      const bool same = submaps[target].path == submaps[source].path;
      if (same && places::horizontal_sigma_m(*guess) < settings.sigma_min_m) continue;
      by_path[submaps[target].path].emplace_back(guess->T_target_source.p.norm(), target, *guess);
    }
    for (auto& [path, found] : by_path) {
      std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
        return std::get<0>(a) < std::get<0>(b);
      });
      const std::size_t n = std::min(found.size(), static_cast<std::size_t>(settings.per_submap));
      for (std::size_t k = 0; k < n; ++k) {
        candidates.push_back({std::get<1>(found[k]), source, std::get<2>(found[k])});
      }
    }
  }
  return candidates;
}

std::vector<LoopCandidate> alike_candidates(std::span<const PathSubmap> submaps, std::size_t path_a,
                                            std::size_t path_b,
                                            const places::DescriptorSettings& descriptor,
                                            const LoopSettings& settings, int tries) {
  const Likenesses alike(submaps, path_a, path_b, descriptor);
  std::vector<Ranked> all;
  for (std::size_t b = 0; b < alike.sources(); ++b) {
    std::vector<Ranked> of_source = alike.ranked(b, settings.row);
    std::move(of_source.begin(), of_source.end(), std::back_inserter(all));
  }
  std::stable_sort(all.begin(), all.end(), [](const Ranked& a, const Ranked& b) {
    return a.rank != b.rank ? a.rank < b.rank : a.score > b.score;
  });
  // Neighbours give the same result: pieces should differ.
  std::vector<LoopCandidate> chosen;
  const auto near = [&](std::size_t i, std::size_t k) {
    return std::abs(submaps[i].path_m - submaps[k].path_m) < settings.view_step_m;
  };
  for (const Ranked& ranked : all) {
    const LoopCandidate& candidate = ranked.candidate;
    if (chosen.size() >= static_cast<std::size_t>(tries)) break;
    const bool known = std::any_of(chosen.begin(), chosen.end(), [&](const LoopCandidate& c) {
      return near(c.target, candidate.target) && near(c.source, candidate.source);
    });
    if (!known) chosen.push_back(candidate);
  }
  return chosen;
}

std::vector<LoopFound> compare_all(std::span<const PathSubmap> submaps,
                                   std::vector<LoopCandidate> candidates,
                                   const places::RecogniseSettings& settings, Executor& executor,
                                   StopFlag stop) {
  std::vector<LoopFound> found(candidates.size());
  executor.for_blocks(candidates.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
    const LoopCandidate& c = candidates[i];
    found[i].candidate = c;
    if (stop.raised()) return;
    found[i].recognition =
        places::recognise(submaps[c.target].submap, submaps[c.source].submap, settings, c.guess);
  });
  return found;
}

}  // namespace rali::fleet
