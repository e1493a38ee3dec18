#pragma once

#include "rali/graph/settings.hpp"
#include "rali/graph/window.hpp"

namespace rali::graph {

/// Computes all free poses from the relative ones, whatever their values: rotations by linear least
/// squares on their nine elements, projected to rotations, then positions with these rotations
/// (Martinec and Pajdla 2007; algorithms_fleet 8.7). Priors and fixed nodes anchor the result; a
/// connected part without one keeps its first node. Ranges are not used. Velocities rotate with
/// their node. The window must be laid out. @return false if the equations have no solution; then
/// nothing has changed.
bool start_from_rotations(Window& window);

/// Does so if chi2 per degree of freedom exceeds the settings', and keeps the result if its cost is
/// lower.
bool start_if_poor(Window& window, const GraphSettings& settings);

/// Residuals minus unknowns; at least 1.
[[nodiscard]] int degrees_of_freedom(const Window& window);

}  // namespace rali::graph
