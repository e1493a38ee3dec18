#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/places/descriptor.hpp"
#include "rali/places/hypotheses.hpp"
#include "rali/places/verify.hpp"

namespace rali::places {

/// How unique the best placement is.
enum class Certainty {
  kUnique,     ///< no other placement fits
  kAlongAxis,  ///< others fit along one direction: only the position along it is uncertain
  kAmbiguous   ///< others fit elsewhere or turned: only a hypothesis
};
inline constexpr ChoiceNames<3> kCertaintyNames{"unique", "along_axis", "ambiguous"};

struct RecogniseSettings {
  HypothesisSettings search;
  AlignSettings align;
  VerifySettings verify;
  double apart_m = 0.5;    ///< placements nearer than this and
  double apart_deg = 6.0;  ///< turned less are one (algorithms_fleet 7.4 step 3)
  double tight_m = 0.35;   ///< a guess better than this and
  double tight_deg = 4.0;  ///< than this is the only start that is tried
  double along_m = 0.4;    ///< rivals within this of one line are along an axis
  /// Another placement rivals the best one only if its contradictions exceed the best's by less
  /// than this
  double rival_conflict = 0.03;
  double rival_overlap = 0.4;  ///< and it has at least this fraction of the best's agreeing points
  /// Walls along a corridor agree everywhere: only surfaces that face along it distinguish places.
  /// The best placement needs this many such agreeing points and this fraction of those seen, over
  /// both views together.
  int facing_min = 12;
  double facing_fraction = 0.3;
  int facing_decides = 30;    ///< with fewer, they do not rank placements
  double rival_facing = 0.4;  ///< a rival needs this fraction of the best's
  /// Without a guess the other end of a corridor fits as well: only several objects along the
  /// corridor, in both views, make a placement unique.
  int stations_min = 3;

  template <class V>
  void visit(V& v) {
    v.group("search", search, "candidates by images from above");
    v.group("align", align, "registration");
    v.group("verify", verify, "which matches are accepted");
    v("apart_m", apart_m, 0.05, 10.0, "placements nearer than this are one");
    v("apart_deg", apart_deg, 0.5, 90.0, "placements turned less than this are one");
    v("tight_m", tight_m, 0.0, 10.0, "a guess better than this needs no search");
    v("tight_deg", tight_deg, 0.0, 90.0, "and its yaw better than this");
    v("along_m", along_m, 0.05, 5.0, "others so near to a line are along an axis");
    v("rival_conflict", rival_conflict, 0.0, 1.0, "more contradictions are no rival");
    v("rival_overlap", rival_overlap, 0.0, 1.0, "fraction of agreeing points that makes a rival");
    v("facing_min", facing_min, 0, 10000, "agreeing points that face along the weakest direction");
    v("facing_fraction", facing_fraction, 0.0, 1.0,
      "their fraction of those that the other has in view");
    v("facing_decides", facing_decides, 0, 10000, "fewer do not decide between two placements");
    v("rival_facing", rival_facing, 0.0, 1.0, "their fraction that makes a rival");
    v("stations_min", stations_min, 0, 100,
      "positions along the path that are tried without a guess");
  }
};

/// One candidate pose of the source in the target, registered and verified.
struct Placement {
  Registration registration;
  Verdict verdict;
};

struct Recognition {
  /// Placements that pass verification, best first (fewest contradictions for their agreement), at
  /// most peaks_max.
  std::vector<Placement> placements;
  Certainty certainty = Certainty::kAmbiguous;           ///< of the first one
  geometry::Vec3 axis_target = geometry::Vec3::UnitX();  ///< if along an axis, horizontal, unit
  int tried = 0;
  /// Of the try that passed most checks, if none passed all; kNone: nothing was tried, or one was
  /// found.
  Refusal refusal = Refusal::kNone;
  /// Contradictions at the pose that the guess allows and that has fewest, if no placement passed:
  /// solid points of one submap in free space of the other, as a fraction of the points both can
  /// judge; 0 where those are too few.
  double conflict_as_guessed = 0.0;

  [[nodiscard]] bool found() const { return !placements.empty(); }

  /// What a pose graph may use at once: found, and not ambiguous. In an ambiguous direction the
  /// information of the first placement is already zero.
  [[nodiscard]] bool usable() const { return found() && certainty != Certainty::kAmbiguous; }
};

/// Registers and verifies all starts, returns those that pass and whether the best one is unique.
/// @param guess placements outside its gate are no rivals and not returned.
[[nodiscard]] Recognition recognise_from(const Submap& target, const Submap& source,
                                         std::span<const geometry::SE3> starts,
                                         const RecogniseSettings& settings,
                                         const std::optional<Guess>& guess = {});

/// The same with its own starts: a tight guess alone, else the candidates of the pictures from
/// above within the guess's gate; without a guess, everywhere.
[[nodiscard]] Recognition recognise(const Submap& target, const Submap& source,
                                    const RecogniseSettings& settings,
                                    const std::optional<Guess>& guess = {});

struct NearSettings {
  double view_m = 12.0;       ///< two submaps with views nearer than this have enough in common
  double gate = 3.0;          ///< in sigma
  double sigma_max_m = 20.0;  ///< a worse guess is not used: query the index

  template <class V>
  void visit(V& v) {
    v("view_m", view_m, 1.0, 100.0, "views nearer than this see enough in common");
    v("gate", gate, 0.0, 10.0, "sigma by which the distance may be less than guessed");
    v("sigma_max_m", sigma_max_m, 0.1, 1000.0, "a worse guess is none");
  }
};

/// Whether two submaps may overlap, by the graph's prediction alone: the distance counts from the
/// views of one to the nearest of the other.
[[nodiscard]] bool may_overlap(const Submap& target, const Submap& source, const Guess& guess,
                               const NearSettings& settings);

}  // namespace rali::places
