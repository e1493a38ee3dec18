#include "rali/map/explore_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "rali/map/ground_height.hpp"

namespace rali::map {
namespace {

using geometry::Vec2;

constexpr std::size_t kKeyframesMax = 60'000;  ///< counters have 16 bits
constexpr double kTurn_rad = 0.004;            ///< half a sector: smaller turns change nothing

double angle_between(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, 2.0 * std::numbers::pi));
}

}  // namespace

OutlineSettings outline_settings(const ExploreSettings& s) {
  constexpr double kAbove_m = 0.2;  // clearance above the vehicle
  return {s.cell_m,        s.range_m, s.band_low_m, s.vehicle_height_m + kAbove_m,
          s.slope_max_deg, s.step_m,  s.drop_m,     s.drop_range_m};
}

ExploreGrid::ExploreGrid(const ExploreSettings& settings)
    : settings_(settings),
      outlines_(outline_settings(settings)),
      evidence_({settings.cell_m, settings.range_m, settings.vehicle_radius_m, settings.cells_max}),
      ground_(settings.ground_below_body_m) {}

bool ExploreGrid::add(KeyframeId id, const KeyframeView& keyframe) {
  if (!is_usable(keyframe)) return false;
  if (move(id, keyframe.T_map_body)) return true;
  if (is_full() || keyframes_.size() >= kKeyframesMax) return false;
  const std::optional<Ground> ground = ground_.below(id.vehicle, keyframe);
  if (!ground) return false;
  Keyframe& kept = keyframes_[id];
  kept.outline = outline_of(keyframe, *ground, outlines_);
  kept.p_map_m = keyframe.T_map_body.p.head<2>();
  kept.yaw_rad = yaw_of(keyframe.T_map_body);
  place(kept, 1);
  return true;
}

bool ExploreGrid::move(KeyframeId id, const geometry::SE3& T_map_body) {
  const auto it = keyframes_.find(id);
  if (it == keyframes_.end()) return false;
  if (!T_map_body.p.allFinite() || !T_map_body.R.allFinite()) return true;
  Keyframe& kept = it->second;
  const double yaw_rad = yaw_of(T_map_body);
  const double moved_m = (kept.p_map_m - T_map_body.p.head<2>()).norm();
  if (moved_m <= settings_.move_m && angle_between(yaw_rad, kept.yaw_rad) <= kTurn_rad) return true;
  place(kept, -1);
  kept.p_map_m = T_map_body.p.head<2>();
  kept.yaw_rad = yaw_rad;
  place(kept, 1);
  return true;
}

bool ExploreGrid::remove(KeyframeId id) {
  const auto it = keyframes_.find(id);
  if (it == keyframes_.end()) return false;
  place(it->second, -1);
  keyframes_.erase(it);
  return true;
}

void ExploreGrid::place(const Keyframe& keyframe, int sign) {
  evidence_.place(keyframe.outline, keyframe.p_map_m, keyframe.yaw_rad, sign);
}

double ExploreGrid::log_odds(const EvidenceGrid::Cell& c) const {
  return std::clamp(settings_.hit * c.hits + settings_.pass * c.passes, settings_.log_odds_min,
                    settings_.log_odds_max);
}

CellState ExploreGrid::state_of(const EvidenceGrid::Cell& c) const {
  if (c.driven > 0) return CellState::kFree;
  if (c.hits == 0 && c.passes == 0) return CellState::kUnknown;
  const double odds = log_odds(c);
  if (odds > settings_.occupied) return CellState::kOccupied;
  // `<=`, so that a single pass (-0.4) is enough.
  return odds <= settings_.free ? CellState::kFree : CellState::kUnknown;
}

double ExploreGrid::log_odds_at(const Vec2& p_map_m) const {
  const EvidenceGrid::Cell* cell = evidence_.find(p_map_m);
  return cell == nullptr ? 0.0 : log_odds(*cell);
}

Result<CellMap> ExploreGrid::picture() const {
  return evidence_.picture([this](const EvidenceGrid::Cell& c) { return state_of(c); },
                           "fleet.explore");
}

}  // namespace rali::map
