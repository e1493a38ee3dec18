#include "rali/places/verify.hpp"

#include <cmath>
#include <numbers>

namespace rali::places {

using geometry::SE3;
using geometry::Vec3;

namespace {

enum class Answer { kAgrees, kContradicts, kSilent };

Answer ask(const Submap& target, const Vec3& x, const Vec3& n, double cos_min, double agree_m) {
  const bool on_plane = n.squaredNorm() > 0.0;
  bool agrees = false;
  bool near_surface = false;
  target.plane_index().near(x, 0.8, [&](std::uint32_t k) {
    const Plane& plane = target.planes()[k];
    const Vec3 d = x - plane.q_m;
    const double off_m = std::abs(plane.n.dot(d));
    if (off_m > 2.0 * agree_m || d.squaredNorm() > plane.radius_m * plane.radius_m) return;
    near_surface = true;
    agrees = agrees || (off_m < agree_m && (!on_plane || n.dot(plane.n) > cos_min));
  });
  if (agrees) return Answer::kAgrees;
  const Sight sight = target.free_space().look(x);
  if (sight == Sight::kHit && !on_plane) return Answer::kAgrees;
  // Beside a surface a small error of the pose is enough to be in front of it.
  return sight == Sight::kFree && !near_surface ? Answer::kContradicts : Answer::kSilent;
}

}  // namespace

Agreement agreement(const Submap& target, const Submap& source, const SE3& T,
                    const VerifySettings& s) {
  const double cos_min = std::cos(s.agree_deg * std::numbers::pi / 180.0);
  Agreement out;
  for (const CheckPoint& check : source.checks()) {
    if (!check.upright) continue;
    ++out.asked;
    const Answer answer = ask(target, T * check.p_m, T.R * check.n, cos_min, s.agree_m);
    out.agree += answer == Answer::kAgrees ? 1 : 0;
    out.conflict += answer == Answer::kContradicts ? 1 : 0;
  }
  return out;
}

Verdict verify(const Submap& target, const Submap& source, const Registration& r,
               const VerifySettings& s) {
  Verdict out;
  if (!r.converged || !r.T_target_source.p.allFinite()) return out;
  out.source_in_target = agreement(target, source, r.T_target_source, s);
  out.target_in_source = agreement(source, target, r.T_target_source.inverse(), s);
  if (r.rms_m > s.rms_max_m) {
    out.refusal = Refusal::kResiduals;
  } else if (out.overlap() < s.overlap_min || out.source_in_target.agree < s.upright_min ||
             out.target_in_source.agree < s.upright_min) {
    out.refusal = Refusal::kOverlap;
  } else if (out.conflict_share() > s.conflict_max) {
    out.refusal = Refusal::kConflict;
  } else {
    out.refusal = Refusal::kNone;
  }
  return out;
}

}  // namespace rali::places
