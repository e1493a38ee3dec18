#include "rali/fleet/rounds/round_machine.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace rali::fleet {
namespace {

std::string reason_of(const map::FrontierArea& f) {
  switch (f.state) {
    case map::FrontierState::kOpen:
      return fmt::format("{:.0f} m2 unknown behind it", f.unknown_area_m2);
    case map::FrontierState::kExplored:
      return "visited without change";
    case map::FrontierState::kTooSmall:
      return "shorter than frontiers.length_min_m";
    case map::FrontierState::kUnreachable:
      return f.tried ? "no vehicle that was sent there found a path"
                     : "no path to it between the obstacles";
  }
  return {};
}

}  // namespace

std::string_view name_of(RoundEnd end) {
  switch (end) {
    case RoundEnd::kOpen:
      return "open";
    case RoundEnd::kFinished:
      return "finished";
    case RoundEnd::kTimeout:
      return "timeout";
    case RoundEnd::kAnchorMoved:
      return "anchor_moved";
    case RoundEnd::kAnchorLost:
      return "anchor_lost";
    case RoundEnd::kExplored:
      return "explored";
    case RoundEnd::kOperator:
      return "operator";
    case RoundEnd::kEndOfData:
      return "end_of_data";
  }
  return "";
}

std::string_view name_of(FinishReason reason) {
  switch (reason) {
    case FinishReason::kNone:
      return "none";
    case FinishReason::kSignal:
      return "signal";
    case FinishReason::kDistance:
      return "distance";
    case FinishReason::kExplored:
      return "explored";
    case FinishReason::kRangeLost:
      return "range_lost";
    case FinishReason::kSigma:
      return "sigma";
    case FinishReason::kUnreachable:
      return "unreachable";
    case FinishReason::kBattery:
      return "battery";
    case FinishReason::kTimeout:
      return "timeout";
    case FinishReason::kOperator:
      return "operator";
  }
  return "";
}

std::string_view name_of(map::FrontierState state) {
  switch (state) {
    case map::FrontierState::kOpen:
      return "open";
    case map::FrontierState::kExplored:
      return "explored";
    case map::FrontierState::kTooSmall:
      return "too_small";
    case map::FrontierState::kUnreachable:
      return "unreachable";
  }
  return "";
}

void RoundMachine::anchor_began(VehicleId anchor, Time t, bool new_round) {
  const bool open = !rows_.empty() && rows_.back().ended_by == RoundEnd::kOpen;
  if (open && rows_.back().anchor == anchor && !new_round) return;
  if (open) close(RoundEnd::kAnchorLost, t);
  if (!rows_.empty()) rows_.back().next_anchor = anchor;
  finished_.clear();
  RoundRow row;
  row.round = round() + 1;
  row.anchor = anchor;
  row.start = t;
  rows_.push_back(row);
}

void RoundMachine::tag_finished(VehicleId vehicle, FinishReason reason) {
  const auto at = std::find_if(finished_.begin(), finished_.end(),
                               [&](const Done& d) { return d.vehicle == vehicle; });
  if (at == finished_.end()) {
    finished_.push_back({vehicle, reason});
  } else {
    at->reason = reason;
  }
}

void RoundMachine::anchor_ended(RoundEnd why, Time t) {
  if (!rows_.empty() && rows_.back().ended_by == RoundEnd::kOpen) close(why, t);
}

void RoundMachine::next_chosen(VehicleId next, std::optional<std::uint32_t> frontier) {
  if (rows_.empty()) return;
  rows_.back().next_anchor = next;
  rows_.back().frontier = frontier;
}

void RoundMachine::frontiers_seen(std::span<const map::FrontierArea> frontiers,
                                  std::span<const VehicleId> vehicles, bool facts_agree) {
  std::vector<FrontierRow> now;
  bool any_open = false;
  for (const map::FrontierArea& f : frontiers) {
    FrontierRow row;
    row.round = round();
    row.id = f.id;
    row.x_m = f.centre_map_m.x();
    row.y_m = f.centre_map_m.y();
    row.length_m = f.length_m;
    if (f.state == map::FrontierState::kOpen && f.nearest < vehicles.size()) {
      row.nearest_vehicle = vehicles[f.nearest];
    }
    row.state = f.state;
    row.reason = reason_of(f);
    row.tried = f.tried;
    any_open = any_open || f.state == map::FrontierState::kOpen;
    now.push_back(std::move(row));
  }
  const auto has = [](const std::vector<FrontierRow>& rows, std::uint32_t id) {
    return std::any_of(rows.begin(), rows.end(), [id](const FrontierRow& r) { return r.id == id; });
  };
  for (FrontierRow& old : seen_) {
    if (old.state != map::FrontierState::kOpen || has(now, old.id) || has(gone_, old.id)) continue;
    old.state = map::FrontierState::kExplored;
    old.reason = "seen";
    old.round = round();
    gone_.push_back(std::move(old));
  }
  seen_ = std::move(now);
  // A list without an open frontier counts only when no keyframe is still in transit.
  looks_without_ = any_open ? 0.0 : looks_without_ + (facts_agree ? 1.0 : 0.0);
}

void RoundMachine::frontier_stopped(std::uint32_t frontier, std::string why) {
  for (FrontierRow& row : seen_) {
    if (row.id == frontier) row.reason = std::move(why);
  }
}

void RoundMachine::end_of_data(Time t) { anchor_ended(RoundEnd::kEndOfData, t); }

std::optional<VehicleId> RoundMachine::anchor() const {
  if (rows_.empty() || rows_.back().ended_by != RoundEnd::kOpen) return std::nullopt;
  return rows_.back().anchor;
}

FinishReason RoundMachine::finished(VehicleId vehicle) const {
  for (const Done& d : finished_) {
    if (d.vehicle == vehicle) return d.reason;
  }
  return FinishReason::kNone;
}

bool RoundMachine::mission_over() const { return looks_without_ >= settings_.evaluations; }

void RoundMachine::close(RoundEnd why, Time t) {
  rows_.back().end = std::max(t, rows_.back().start);
  rows_.back().ended_by = why;
  frontier_rows_.insert(frontier_rows_.end(), seen_.begin(), seen_.end());
  frontier_rows_.insert(frontier_rows_.end(), gone_.begin(), gone_.end());
  seen_.clear();
  gone_.clear();
}

}  // namespace rali::fleet
