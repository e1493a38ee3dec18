#pragma once

#include <array>
#include <string>
#include <vector>

#include "pieces.hpp"

namespace rali::recognition {

/// How far each pair of one place comes when nothing tells where to look.
struct Stages {
  std::string scene;
  int same = 0;       ///< pairs of one place
  int candidate = 0;  ///< found by the index, among as many as settings allow
  int start = 0;      ///< a start within 1 m and 10 deg of the truth
  int home = 0;       ///< a start from which registration gets within 0.3 m and 3 deg
  int believed = 0;   ///< and is believable
  int best = 0;       ///< and is the first of all placements
  int usable = 0;     ///< and not ambiguous
  std::array<int, 5> refused_at_truth{};  ///< places::Refusal of what the truth leads to
};

/// @param across only pieces of two vehicles; @param pairs_max so many are tried at most, evenly
/// chosen
[[nodiscard]] Stages stages(const std::string& scene, const std::vector<Piece>& pieces,
                            const places::PlacesSettings& settings, bool across,
                            std::size_t pairs_max, bool verbose);

}  // namespace rali::recognition
