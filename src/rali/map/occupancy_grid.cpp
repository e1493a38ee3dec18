#include "rali/map/occupancy_grid.hpp"

namespace rali::map {
namespace {

/// Half the width of a narrow vehicle: where it was, nothing is.
constexpr double kVehicle_m = 0.2;

OutlineSettings outline_settings(const GridSettings& s) {
  OutlineSettings out;
  out.cell_m = s.cell_m;
  out.range_m = s.range_m;
  out.low_m = out.step_m = s.z_m[0];
  out.high_m = s.z_m[1];
  return out;
}

}  // namespace

GridBuilder::GridBuilder(const GridSettings& settings)
    : settings_(settings),
      outlines_(outline_settings(settings)),
      evidence_({settings.cell_m, settings.range_m, kVehicle_m, settings.cells_max}),
      ground_(settings.ground_below_body_m) {}

void GridBuilder::add(const KeyframeView& keyframe) {
  if (!is_usable(keyframe) || evidence_.is_full()) return;
  const std::optional<Ground> ground = ground_.below(VehicleId{keyframe.vehicle}, keyframe);
  if (!ground) return;
  evidence_.place(outline_of(keyframe, *ground, outlines_), keyframe.T_map_body.p.head<2>(),
                  yaw_of(keyframe.T_map_body), 1);
}

CellState GridBuilder::state_of(const EvidenceGrid::Cell& c) const {
  if (c.hits == 0) return c.passes + c.driven > 0 ? CellState::kFree : CellState::kUnknown;
  const double hits = c.hits, looks = hits + c.passes;
  const bool often = hits >= settings_.hits_min && hits >= settings_.hit_fraction * looks;
  return c.driven == 0 && (c.passes == 0 || often) ? CellState::kOccupied : CellState::kFree;
}

Result<CellMap> GridBuilder::finish() const {
  constexpr std::string_view kSettings = "map.grid";
  if (evidence_.is_full()) return evidence_.too_large(kSettings);
  return evidence_.picture([this](const EvidenceGrid::Cell& c) { return state_of(c); }, kSettings);
}

}  // namespace rali::map
