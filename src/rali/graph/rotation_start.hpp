#pragma once

#include "rali/graph/settings.hpp"
#include "rali/graph/window.hpp"

namespace rali::graph {

/// Sets all free poses from the relative ones, whatever they were: rotations by linear least
/// squares on their nine elements, made rotations again, then positions with these rotations
/// (Martinec and Pajdla 2007; algorithms_fleet 8.7). Priors and fixed nodes hold their place; a
/// part of the graph without one holds its first node. Ranges are not used. Velocities turn with
/// their node. The window must be laid out. @return false if the equations have no solution; then
/// nothing has moved.
bool start_from_rotations(Window& window);

/// Does so if chi2 per degree of freedom exceeds the settings', and keeps it if the cost is less.
bool start_if_poor(Window& window, const GraphSettings& settings);

/// Residuals less unknowns; at least 1.
[[nodiscard]] int degrees_of_freedom(const Window& window);

}  // namespace rali::graph
