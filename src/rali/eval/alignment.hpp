#pragma once

#include "rali/base/settings.hpp"
#include "rali/eval/association.hpp"

namespace rali::eval {

enum class Alignment {
  kNone,    ///< both are in the same frame
  kOrigin,  ///< first poses coincide
  kSe3,     ///< best rotation and translation, no scale (Umeyama)
  kYaw      ///< best rotation about z and translation: z is vertical in both frames
};
inline constexpr ChoiceNames<4> kAlignmentNames{"none", "origin", "se3", "yaw"};

/// T_ref_est that maps the estimate to the reference. For a fleet, pass the pairs of all vehicles:
/// one transform for all. Errors (kNoAnswer): no pairs; positions on one line or point, which do
/// not determine the rotation.
/// Source: Umeyama, IEEE PAMI 13(4), 1991, eq. (38)-(42) with c = 1.
[[nodiscard]] Result<geometry::SE3> align(const PairList& pairs, Alignment how);

}  // namespace rali::eval
