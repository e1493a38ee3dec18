#include "rali/config/suggest.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace rali::config {
namespace {

constexpr std::size_t kLongestWord = 64;  // longer ones are not typing mistakes
constexpr std::size_t kMaxListed = 10;

/// Edit distance that counts a swap of adjacent characters once (optimal string alignment).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        now[j] = std::min(now[j], before[j - 2] + 1);
      }
    }
    before.swap(last);
    last.swap(now);
  }
  return last[b.size()];
}

/// Distance of names: a prefix counts as near, since people leave out the unit.
std::size_t name_distance(std::string_view word, std::string_view name) {
  const std::string_view shorter = word.size() < name.size() ? word : name;
  const std::string_view longer = word.size() < name.size() ? name : word;
  if (shorter.size() >= 3 && longer.substr(0, shorter.size()) == shorter) return 1;
  return edit_distance(word, name);
}

}  // namespace

std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates) {
  if (word.empty() || word.size() > kLongestWord) return {};
  const std::size_t maximum = std::max<std::size_t>(1, std::min<std::size_t>(3, word.size() / 3));
  std::size_t best = std::numeric_limits<std::size_t>::max();
  std::string nearest;
  for (const std::string& candidate : candidates) {
    if (candidate.size() > kLongestWord) continue;
    const std::size_t distance = name_distance(word, candidate);
    if (distance <= maximum && distance < best) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& candidates) {
  const std::string nearest = nearest_name(word, candidates);
  if (!nearest.empty()) return fmt::format("Did you mean '{}'?", nearest);
  if (candidates.empty() || candidates.size() > kMaxListed) return {};
  return fmt::format("Known here: {}.", fmt::join(candidates, ", "));
}

}  // namespace rali::config
