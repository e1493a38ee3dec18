#pragma once

#include <string>
#include <vector>

#include "rali/report/plot/map_view.hpp"

namespace rali::report {

/// Blind stretches of a way, each marked by what held it.
[[nodiscard]] std::vector<MapStretch> blind_stretches(const VehicleView& v);

/// Bars or arrows along the blind axis on the blind stretches, evenly along the ways.
void add_blind_bars(const RunData& run, MapView& view);

/// What stretches, bars and arrows of the view mean (HTML); empty if it has none.
[[nodiscard]] std::string blind_legend(const MapView& view);

}  // namespace rali::report
