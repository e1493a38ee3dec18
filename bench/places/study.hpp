#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pieces.hpp"

namespace rali::recognition {

struct StudyOptions {
  std::size_t pairs_max = 60;  ///< largest number of pairs of each kind (same place, other place)
  double guess_m = 1.0;        ///< error of the guess, sd
  double guess_deg = 3.0;
  std::uint64_t seed = 1;
  bool verbose = false;  ///< wrong results to stderr
};

/// Results of the pairs for one kind of query.
struct Outcome {
  int same = 0, other = 0;  ///< pairs that truly overlap, and others
  int unique = 0;           ///< usable and unique
  int along = 0;            ///< usable except along one axis
  int ambiguous = 0;
  int full = 0;                            ///< unique and full rank
  int wrong_full = 0;                      ///< of these: off by more than 0.3 m or 3 deg
  int wrong = 0;                           ///< usable, that wrong in observable directions
  std::vector<double> error_m, error_deg;  ///< of correct full-rank ones
  std::vector<double> nees;                ///< per degree of freedom, of correct usable ones
  double ms = 0.0;                         ///< of all pairs
};

struct Figures {
  std::string scene;
  std::size_t pieces = 0;
  int asked = 0, recalled = 0;    ///< places with a partner, and those found among candidates
  int candidates = 0, right = 0;  ///< returned, and truly overlapping
  Outcome global, guided;
  std::vector<double> align_ms;
  double make_ms = 0.0, describe_ms = 0.0;
};

[[nodiscard]] Figures study(const std::string& scene, const std::vector<Piece>& pieces,
                            const places::PlacesSettings& settings, const StudyOptions& options);

}  // namespace rali::recognition
