#pragma once

#include <optional>

#include "rali/ranging/passage_walls.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// How far aside of the own antenna another one stands, in a passage.
struct Aside {
  double mean_m = 0.0;  ///< along up x axis
  double sigma_m = 1.0;
};

/// As much as a passage leaves to whoever is heard in it: its bends hide more of it from afar.
/// @param by_walls what walls tell of it, if they do
[[nodiscard]] Aside aside_in_passage(const FinderSettings& settings,
                                     const std::optional<Aside>& by_walls, double range_m);

/// Whoever stands between two walls: anywhere, but not nearer to them than half a vehicle.
[[nodiscard]] Aside aside_between_walls(const FinderSettings& settings, const PassageWalls& own);

/// Each knows the walls beside it: seen from the middle of the passage, one stands so much farther
/// left than the other. Where it is not as wide for both, either may have a box beside it.
/// @param other in the frame of `own`  @return nothing if the two passages lead elsewhere
[[nodiscard]] std::optional<Aside> aside_by_walls(const FinderSettings& settings,
                                                  const PassageWalls& own,
                                                  const PassageWalls& other);

}  // namespace rali::ranging
