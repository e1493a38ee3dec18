#pragma once

#include <algorithm>

#include "rali/base/settings.hpp"
#include "rali/places/align.hpp"

namespace rali::places {

struct VerifySettings {
  double agree_m = 0.12;       ///< a point so near to a plane of the other agrees with it
  double agree_deg = 30.0;     ///< if its own plane faces the same way
  double conflict_max = 0.04;  ///< share of solid upright points in the other's empty space
  double overlap_min = 0.30;   ///< share of upright points that agree; of the better view
  int upright_min = 40;        ///< points on walls and things that agree
  double rms_max_m = 0.05;

  template <class V>
  void visit(V& v) {
    v("agree_m", agree_m, 0.01, 1.0, "a point so near to a plane of the other agrees with it");
    v("agree_deg", agree_deg, 1.0, 90.0, "and both planes face the same way within this");
    v("conflict_max", conflict_max, 0.0, 1.0, "fraction of solid points in the other's free space");
    v("overlap_min", overlap_min, 0.0, 1.0, "fraction of points that agree, of the better view");
    v("upright_min", upright_min, 1, 100000, "points on walls and things that agree");
    v("rms_max_m", rms_max_m, 0.001, 1.0, "distance of partners");
  }
};

/// How one submap's points fare in the other: upright ones only, floors agree everywhere.
struct Agreement {
  int asked = 0;
  int agree = 0;
  int conflict = 0;  ///< solid, where the other's rays went through
  int stations = 0;  ///< places along the axis with several that agree, if an axis was asked for

  [[nodiscard]] double overlap() const {
    return asked > 0 ? static_cast<double>(agree) / asked : 0.0;
  }

  [[nodiscard]] double conflict_share() const {
    const int told = agree + conflict;
    return told > 0 ? static_cast<double>(conflict) / told : 1.0;
  }
};

/// By the check that refused, in the order in which they are made.
enum class Refusal { kNone, kNotConverged, kOutsideGuess, kResiduals, kOverlap, kConflict };
inline constexpr ChoiceNames<6> kRefusalNames{"none",      "not_converged", "outside_guess",
                                              "residuals", "overlap",       "conflict"};

/// Whether two submaps can lie so to each other.
struct Verdict {
  Refusal refusal = Refusal::kNotConverged;
  Agreement source_in_target, target_in_source;
  /// Of what faces along the least known horizontal direction, both ways.
  Agreement along_in_target, along_in_source;

  [[nodiscard]] bool believable() const { return refusal == Refusal::kNone; }

  [[nodiscard]] double conflict_share() const {
    return std::max(source_in_target.conflict_share(), target_in_source.conflict_share());
  }

  [[nodiscard]] double overlap() const {
    return std::max(source_in_target.overlap(), target_in_source.overlap());
  }
};

/// The same, only of points on planes that face along `axis_target` (unit): those decide the place
/// along it. `asked` are those at which the other submap could have said something.
[[nodiscard]] Agreement agreement_along(const Submap& target, const Submap& source,
                                        const geometry::SE3& T_target_source,
                                        const geometry::Vec3& axis_target,
                                        const VerifySettings& settings);

[[nodiscard]] Agreement agreement(const Submap& target, const Submap& source,
                                  const geometry::SE3& T_target_source,
                                  const VerifySettings& settings);

/// Judges a registration by what no fit of planes sees: whether each view's walls and things are
/// where the other saw nothing (algorithms_fleet 7.5). That it is the only place that fits is
/// another question: see recognise().
[[nodiscard]] Verdict verify(const Submap& target, const Submap& source,
                             const Registration& registration, const VerifySettings& settings);

}  // namespace rali::places
