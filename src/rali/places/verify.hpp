#pragma once

#include <algorithm>

#include "rali/base/settings.hpp"
#include "rali/places/align.hpp"

namespace rali::places {

struct VerifySettings {
  double agree_m = 0.12;       ///< a point this near to a plane of the other agrees with it
  double agree_deg = 30.0;     ///< if its own plane has the same orientation
  double conflict_max = 0.04;  ///< fraction of solid upright points in the other's free space
  double overlap_min = 0.30;   ///< fraction of upright points that agree; of the better view
  int upright_min = 40;        ///< agreeing points on walls and objects
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

/// Check of one submap's points against the other: upright ones only, floors agree everywhere.
struct Agreement {
  int asked = 0;
  int agree = 0;
  int conflict = 0;  ///< solid, where the other's rays passed through
  int stations = 0;  ///< separate positions along the axis with several agreeing points, if an axis
                     ///< was given

  [[nodiscard]] double overlap() const {
    return asked > 0 ? static_cast<double>(agree) / asked : 0.0;
  }

  [[nodiscard]] double conflict_fraction() const {
    const int reported = agree + conflict;
    return reported > 0 ? static_cast<double>(conflict) / reported : 1.0;
  }
};

/// By the check that refused, in the order of the checks.
enum class Refusal { kNone, kNotConverged, kOutsideGuess, kResiduals, kOverlap, kConflict };
inline constexpr ChoiceNames<6> kRefusalNames{"none",      "not_converged", "outside_guess",
                                              "residuals", "overlap",       "conflict"};

/// Whether a relative pose of two submaps is plausible.
struct Verdict {
  Refusal refusal = Refusal::kNotConverged;
  Agreement source_in_target, target_in_source;
  /// Of surfaces facing along the least constrained horizontal direction, both ways.
  Agreement along_in_target, along_in_source;

  [[nodiscard]] bool believable() const { return refusal == Refusal::kNone; }

  [[nodiscard]] double conflict_fraction() const {
    return std::max(source_in_target.conflict_fraction(), target_in_source.conflict_fraction());
  }

  [[nodiscard]] double overlap() const {
    return std::max(source_in_target.overlap(), target_in_source.overlap());
  }
};

/// The same, only for points on planes that face along `axis_target` (unit): those determine the
/// position along it. `asked` counts points at which the other submap has any evidence.
[[nodiscard]] Agreement agreement_along(const Submap& target, const Submap& source,
                                        const geometry::SE3& T_target_source,
                                        const geometry::Vec3& axis_target,
                                        const VerifySettings& settings);

[[nodiscard]] Agreement agreement(const Submap& target, const Submap& source,
                                  const geometry::SE3& T_target_source,
                                  const VerifySettings& settings);

/// Verifies a registration with evidence that plane residuals lack: whether walls and objects of
/// each submap lie in free space of the other (algorithms_fleet 7.5). Uniqueness is not tested: see
/// recognise().
[[nodiscard]] Verdict verify(const Submap& target, const Submap& source,
                             const Registration& registration, const VerifySettings& settings);

}  // namespace rali::places
