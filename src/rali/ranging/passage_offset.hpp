#pragma once

#include <optional>

#include "rali/ranging/passage_walls.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// Lateral offset of another antenna from the own one, in a passage.
struct LateralOffset {
  double mean_m = 0.0;  ///< along up x axis
  double sigma_m = 1.0;
};

/// Lateral offset of a peer somewhere in the passage. Its sigma grows with the range, since bends
/// are not seen from afar. @param by_walls the offset by the walls, if they are seen
[[nodiscard]] LateralOffset lateral_offset_in_passage(const FinderSettings& settings,
                                                      const std::optional<LateralOffset>& by_walls,
                                                      double range_m);

/// Lateral offset of a peer anywhere between the two walls, but not nearer than half a vehicle.
[[nodiscard]] LateralOffset lateral_offset_between_walls(const FinderSettings& settings,
                                                         const PassageWalls& own);

/// Lateral offset from the walls beside both vehicles: the difference of their offsets from the
/// middle of the passage. A difference of the two widths raises sigma, since either may have a box
/// beside it. @param other in the frame of `own`  @return empty if the two passages differ in
/// direction
[[nodiscard]] std::optional<LateralOffset> lateral_offset_by_walls(const FinderSettings& settings,
                                                                   const PassageWalls& own,
                                                                   const PassageWalls& other);

}  // namespace rali::ranging
