#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rali/report/plot/state_runs.hpp"
#include "rali/report/plot/time_rows.hpp"
#include "rali/report/run_data.hpp"

namespace rali::report {

/// A vehicle's strip over time and, to be switched to, over its way: how much the LiDAR saw along
/// the worst direction, what held the vehicle along it, where ranges were heard, and how far off it
/// may be along it (HTML). Empty if there is no degeneracy file.
/// @param number of the vehicle: its switch needs a name of its own
[[nodiscard]] std::string blind_strip_html(const RunData& run, const VehicleView& v,
                                           std::size_t number);

/// One row over time: what held the vehicle along its worst direction.
[[nodiscard]] TimeRow held_row(const VehicleView& v, double end_s);

/// What the bars of held_row mean (HTML).
[[nodiscard]] std::string_view held_legend();

/// How `by` is drawn: the class of the style sheet.
[[nodiscard]] std::string_view held_class(HeldBy by);
[[nodiscard]] std::string_view held_words(HeldBy by);

/// Stretches of time that were blind, by what held them: few enough to be drawn. The state is a
/// HeldBy.
[[nodiscard]] std::vector<StateRun> blind_runs(const VehicleView& v, std::size_t columns);

}  // namespace rali::report
