#pragma once

#include <array>
#include <string>
#include <vector>

#include "pieces.hpp"

namespace rali::recognition {

/// Number of pairs of the same place that pass each stage of recognition without a prior guess.
struct Stages {
  std::string scene;
  int same = 0;       ///< pairs of the same place
  int candidate = 0;  ///< proposed by the index, within the number that settings allow
  int start = 0;      ///< a start within 1 m and 10 deg of the truth
  int home = 0;       ///< a start from which registration converges within 0.3 m and 3 deg
  int assumed = 0;    ///< and passes the verification
  int best = 0;       ///< and is ranked first of all placements
  int usable = 0;     ///< and not ambiguous
  std::array<int, 5> refused_at_truth{};  ///< places::Refusal when started at ground truth
};

/// @param across only submaps of two vehicles; @param pairs_max largest number of pairs tried,
/// evenly chosen
[[nodiscard]] Stages stages(const std::string& scene, const std::vector<Piece>& pieces,
                            const places::PlacesSettings& settings, bool across,
                            std::size_t pairs_max, bool verbose);

}  // namespace rali::recognition
