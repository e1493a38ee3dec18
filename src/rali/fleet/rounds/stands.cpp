#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "rali/fleet/rounds/round_machine.hpp"

namespace rali::fleet {
namespace {

constexpr double kGap_s = 2.0;  ///< between two marks; beyond it the state is unknown

}  // namespace

void StandFinder::add(Time t, bool at_rest) {
  if (since_ && (t < last_ || seconds_between(last_, t) > kGap_s)) close();
  // A mark gives the state at t: a standstill ends at its last mark.
  if (!at_rest) close();
  if (at_rest && !since_) since_ = t;
  last_ = t;
}

void StandFinder::close() {
  if (since_ && seconds_between(*since_, last_) >= stand_min_s_) {
    stands_.push_back({vehicle_, *since_, last_});
  }
  since_.reset();
}

std::vector<Stand> StandFinder::stands() const {
  StandFinder copy = *this;
  copy.close();
  return copy.stands_;
}

std::vector<RoundRow> rounds_of_stands(std::span<const Stand> stands, double stand_min_s) {
  std::vector<Stand> open;
  for (const Stand& s : stands) {
    if (seconds_between(s.start, s.end) >= stand_min_s) open.push_back(s);
  }
  std::sort(open.begin(), open.end(), [](const Stand& a, const Stand& b) {
    return std::tuple(a.start, a.vehicle, a.end) < std::tuple(b.start, b.vehicle, b.end);
  });
  std::vector<RoundRow> rows;
  Time t = open.empty() ? Time{} : open.front().start;
  for (;;) {
    const Stand* best = nullptr;   // of the vehicles at standstill at t, the one that stays longest
    const Stand* later = nullptr;  // else the next one to stop
    for (const Stand& s : open) {
      if (s.start > t && later == nullptr) later = &s;
      if (s.start <= t && s.end > t && (best == nullptr || s.end > best->end)) best = &s;
    }
    if (best == nullptr && later == nullptr) return rows;
    if (best == nullptr) {
      t = later->start;
      continue;
    }
    RoundRow row;
    row.round = static_cast<std::uint32_t>(rows.size()) + 1;
    row.anchor = best->vehicle;
    row.start = t;
    row.end = best->end;
    row.ended_by = RoundEnd::kAnchorMoved;
    if (!rows.empty()) rows.back().next_anchor = row.anchor;
    rows.push_back(row);
    t = best->end;
  }
}

Result<std::vector<RoundRow>> rounds_of_table(std::span<const Stand> table) {
  std::vector<RoundRow> rows;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const Stand& s = table[i];
    const std::string where = fmt::format("row {}", i + 1);
    if (s.end <= s.start) {
      return fail(ErrorCode::kInput, where,
                  fmt::format("the round ends at {:.3f} s, not after its start at {:.3f} s",
                              s.end.s(), s.start.s()),
                  "Give start_s and end_s of the round in this order.");
    }
    if (!rows.empty() && s.start < *rows.back().end) {
      return fail(ErrorCode::kInput, where,
                  fmt::format("the round starts at {:.3f} s, before the one above ends at {:.3f} s",
                              s.start.s(), rows.back().end->s()),
                  "Sort the rounds by time and let one anchor stand still at a time.");
    }
    if (!rows.empty()) rows.back().next_anchor = s.vehicle;
    RoundRow row;
    row.round = static_cast<std::uint32_t>(i) + 1;
    row.anchor = s.vehicle;
    row.start = s.start;
    row.end = s.end;
    row.ended_by = RoundEnd::kOperator;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace rali::fleet
