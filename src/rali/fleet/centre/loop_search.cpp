#include "rali/fleet/centre/loop_search.hpp"

#include <algorithm>
#include <map>
#include <tuple>

namespace rali::fleet {

namespace {

/// Pieces of one path see the same while the vehicle passes: that is no loop.
bool may_be_loop(const PathSubmap& a, const PathSubmap& b, double apart_m) {
  return a.path != b.path || std::abs(a.way_m - b.way_m) >= apart_m;
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
      if (!guess || !places::may_overlap(*guess, near)) continue;
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
                                            const LoopSettings& settings) {
  places::PlaceIndex index(descriptor);
  std::map<KeyframeId, std::size_t> by_id;
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    if (submaps[i].path != path_a) continue;
    index.add(submaps[i].submap.middle(), submaps[i].descriptor);
    by_id[submaps[i].submap.middle()] = i;
  }
  std::vector<std::pair<double, LoopCandidate>> all;
  for (std::size_t source = 0; source < submaps.size(); ++source) {
    if (submaps[source].path != path_b) continue;
    const auto found = index.query(submaps[source].descriptor, [](KeyframeId) { return false; });
    for (const places::Candidate& c : found) {
      all.push_back({c.score, {by_id.at(c.id), source, std::nullopt}});
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  // Neighbours tell the same: pieces are to differ.
  std::vector<LoopCandidate> chosen;
  const auto near = [&](std::size_t i, std::size_t k) {
    return std::abs(submaps[i].way_m - submaps[k].way_m) < settings.view_step_m;
  };
  for (const auto& [score, found] : all) {
    const LoopCandidate& candidate = found;  // clang 14 captures no part of a pair
    if (chosen.size() >= static_cast<std::size_t>(settings.blind_tries)) break;
    const bool known = std::any_of(chosen.begin(), chosen.end(), [&](const LoopCandidate& c) {
      return near(c.target, candidate.target) && near(c.source, candidate.source);
    });
    if (!known) chosen.push_back(candidate);
  }
  return chosen;
}

std::vector<LoopFound> compare_all(std::span<const PathSubmap> submaps,
                                   std::vector<LoopCandidate> candidates,
                                   const places::RecogniseSettings& settings, Executor& executor) {
  std::vector<LoopFound> found(candidates.size());
  executor.for_blocks(candidates.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
    const LoopCandidate& c = candidates[i];
    found[i].recognition =
        places::recognise(submaps[c.target].submap, submaps[c.source].submap, settings, c.guess);
    found[i].candidate = c;
  });
  return found;
}

}  // namespace rali::fleet
