#pragma once

#include <vector>

#include "pieces.hpp"

namespace rali::recognition {

/// Two submaps without a common scan.
struct Pair {
  std::size_t a = 0, b = 0;
  geometry::SE3 T_a_b;  ///< true
  bool same = false;    ///< a third of the structure in one is visible in the other too
};

/// @param across only submaps of two vehicles
[[nodiscard]] std::vector<Pair> truth_pairs(const std::vector<Piece>& pieces,
                                            const places::PlacesSettings& settings, bool across);

/// True if a query with b returns a within the number of candidates that settings allow; submaps
/// that share a scan with b are not in the index.
[[nodiscard]] bool is_candidate(const Pair& pair, const std::vector<Piece>& pieces,
                                const places::PlacesSettings& settings, bool across);

}  // namespace rali::recognition
