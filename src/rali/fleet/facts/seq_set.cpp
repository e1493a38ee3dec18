#include "rali/fleet/facts/seq_set.hpp"

#include <iterator>
#include <limits>

namespace rali::fleet {

bool SeqSet::contains(std::uint32_t seq) const {
  auto after = intervals_.upper_bound(seq);
  return after != intervals_.begin() && std::prev(after)->second >= seq;
}

bool SeqSet::insert(std::uint32_t seq) {
  if (contains(seq)) return false;
  insert_interval(seq, seq);
  return true;
}

/// The interval must not overlap held ones; it may touch them.
void SeqSet::insert_interval(std::uint32_t first, std::uint32_t last) {
  size_ += std::size_t{last - first} + 1;
  auto after = intervals_.upper_bound(first);
  if (after != intervals_.end() && last + 1 == after->first) {
    last = after->second;
    after = intervals_.erase(after);
  }
  if (after != intervals_.begin()) {
    const auto before = std::prev(after);
    if (first != 0 && before->second == first - 1) {
      before->second = last;
      return;
    }
  }
  intervals_.emplace_hint(after, first, last);
}

std::uint64_t SeqSet::end() const {
  return intervals_.empty() ? 0 : std::uint64_t{intervals_.rbegin()->second} + 1;
}

std::size_t SeqSet::gap_count() const {
  if (intervals_.empty()) return 0;
  return intervals_.size() - (intervals_.begin()->first == 0 ? 1 : 0);
}

std::size_t SeqSet::gap_count_with(std::uint32_t seq) const {
  if (contains(seq)) return gap_count();
  const bool after_held = seq != 0 && contains(seq - 1);
  const bool before_held = seq != std::numeric_limits<std::uint32_t>::max() && contains(seq + 1);
  if (intervals_.empty() || seq >= end()) return gap_count() + (seq != end() ? 1 : 0);
  // It lies in a gap: it splits the gap, shortens it at one end, or fills it.
  const bool at_first = seq == 0 || after_held;
  return gap_count() + 1 - (at_first ? 1 : 0) - (before_held ? 1 : 0);
}

std::vector<SeqInterval> SeqSet::gaps() const {
  std::vector<SeqInterval> gaps;
  std::uint32_t next = 0;
  for (const auto& [first, last] : intervals_) {
    if (first > next) gaps.push_back({next, first - 1});
    next = last + 1;  // wraps only after the last interval
  }
  return gaps;
}

std::optional<std::uint32_t> SeqSet::first_gap(std::uint32_t from) const {
  auto after = intervals_.upper_bound(from);
  std::uint64_t seq = from;
  if (after != intervals_.begin() && std::prev(after)->second >= from) {
    seq = std::uint64_t{std::prev(after)->second} + 1;
  }
  if (seq >= end()) return std::nullopt;
  return static_cast<std::uint32_t>(seq);
}

std::optional<std::uint32_t> SeqSet::first_lacking(const SeqSet& other, std::uint32_t from) const {
  std::uint64_t seq = from;
  while (seq < other.end()) {
    auto after = other.intervals_.upper_bound(static_cast<std::uint32_t>(seq));
    const bool inside = after != other.intervals_.begin() && std::prev(after)->second >= seq;
    if (!inside) {
      seq = after->first;  // exists, as seq < other.end()
      continue;
    }
    auto held = intervals_.upper_bound(static_cast<std::uint32_t>(seq));
    if (held == intervals_.begin() || std::prev(held)->second < seq) {
      return static_cast<std::uint32_t>(seq);
    }
    seq = std::uint64_t{std::prev(held)->second} + 1;
  }
  return std::nullopt;
}

SeqSet SeqSet::from(const StreamInventory& inventory) {
  SeqSet set;
  std::uint64_t next = 0;
  for (const SeqInterval& gap : inventory.gaps) {
    // Beyond inconsistent gaps the held numbers are unknown.
    if (gap.first < next || gap.last < gap.first || gap.last >= inventory.end) return set;
    if (gap.first > next) {
      set.insert_interval(static_cast<std::uint32_t>(next), gap.first - 1);
    }
    next = std::uint64_t{gap.last} + 1;
  }
  if (inventory.end > next) {
    set.insert_interval(static_cast<std::uint32_t>(next), inventory.end - 1);
  }
  return set;
}

}  // namespace rali::fleet
