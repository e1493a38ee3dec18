#pragma once

#include <vector>

#include "pieces.hpp"

namespace rali::recognition {

/// Two pieces without a scan in common.
struct Pair {
  std::size_t a = 0, b = 0;
  geometry::SE3 T_a_b;  ///< true
  bool same = false;    ///< a third of what one has of walls and things is seen by the other too
};

/// @param across only pieces of two vehicles
[[nodiscard]] std::vector<Pair> truth_pairs(const std::vector<Piece>& pieces,
                                            const places::PlacesSettings& settings, bool across);

/// Whether the index names a when asked for b, among as many as the settings allow; places that
/// share a scan with b are not asked.
[[nodiscard]] bool is_candidate(const Pair& pair, const std::vector<Piece>& pieces,
                                const places::PlacesSettings& settings, bool across);

}  // namespace rali::recognition
