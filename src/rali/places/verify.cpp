#include "rali/places/verify.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace rali::places {

using geometry::SE3;
using geometry::Vec3;

namespace {

enum class Answer { kAgrees, kContradicts, kDiffers, kSilent };

/// @param T of the check's submap in the target
Answer ask(const Submap& target, const CheckPoint& check, const SE3& T, double cos_min,
           double agree_m) {
  const Vec3 x = T * check.p_m.cast<double>();
  const Vec3 n = T.R * check.n.cast<double>();
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
  const bool hit = sight == Sight::kHit || sight == Sight::kLoose;
  if (hit && !on_plane) return Answer::kAgrees;
  // Near a surface a small pose error suffices to put a point in front of it. A point that its own
  // scans passed through is no evidence either: people leave trails.
  if (sight == Sight::kFree && !near_surface) {
    return check.solid ? Answer::kContradicts : Answer::kSilent;
  }
  return near_surface || sight != Sight::kUnknown ? Answer::kDiffers : Answer::kSilent;
}

/// Groups of at least kSeveral values, apart by more than kApart_m.
int stations_of(std::vector<double>& along_m) {
  constexpr double kApart_m = 0.5;
  constexpr std::size_t kSeveral = 3;
  std::sort(along_m.begin(), along_m.end());
  int stations = 0;
  std::size_t begin = 0;
  for (std::size_t k = 1; k <= along_m.size(); ++k) {
    if (k < along_m.size() && along_m[k] - along_m[k - 1] < kApart_m) continue;
    stations += k - begin >= kSeveral ? 1 : 0;
    begin = k;
  }
  return stations;
}

}  // namespace

Agreement agreement(const Submap& target, const Submap& source, const SE3& T,
                    const VerifySettings& s) {
  const double cos_min = std::cos(s.agree_deg * std::numbers::pi / 180.0);
  Agreement out;
  for (const CheckPoint& check : source.checks()) {
    if (!check.upright) continue;
    ++out.asked;
    const Answer answer = ask(target, check, T, cos_min, s.agree_m);
    out.agree += answer == Answer::kAgrees ? 1 : 0;
    out.conflict += answer == Answer::kContradicts ? 1 : 0;
  }
  return out;
}

Agreement agreement_along(const Submap& target, const Submap& source, const SE3& T,
                          const Vec3& axis_target, const VerifySettings& s) {
  constexpr double kFaces = 0.6;  // less than 53 degrees off the axis
  const double cos_min = std::cos(s.agree_deg * std::numbers::pi / 180.0);
  Agreement out;
  std::vector<double> along_m;
  for (const CheckPoint& check : source.checks()) {
    if (std::abs((T.R * check.n.cast<double>()).dot(axis_target)) < kFaces) continue;
    const Answer answer = ask(target, check, T, cos_min, s.agree_m);
    out.asked += answer != Answer::kSilent ? 1 : 0;
    out.agree += answer == Answer::kAgrees ? 1 : 0;
    out.conflict += answer == Answer::kContradicts ? 1 : 0;
    if (answer == Answer::kAgrees)
      along_m.push_back((T * check.p_m.cast<double>()).dot(axis_target));
  }
  out.stations = stations_of(along_m);
  return out;
}

Verdict verify(const Submap& target, const Submap& source, const Registration& r,
               const VerifySettings& s) {
  Verdict out;
  if (!r.converged || !r.T_target_source.p.allFinite()) return out;
  out.source_in_target = agreement(target, source, r.T_target_source, s);
  const SE3 back = r.T_target_source.inverse();
  out.target_in_source = agreement(source, target, back, s);
  const Vec3 axis = r.directions[0].direction_odom;
  out.along_in_target = agreement_along(target, source, r.T_target_source, axis, s);
  out.along_in_source = agreement_along(source, target, back, back.R * axis, s);
  if (r.rms_m > s.rms_max_m) {
    out.refusal = Refusal::kResiduals;
  } else if (out.overlap() < s.overlap_min || out.source_in_target.agree < s.upright_min ||
             out.target_in_source.agree < s.upright_min) {
    out.refusal = Refusal::kOverlap;
  } else if (out.conflict_fraction() > s.conflict_max) {
    out.refusal = Refusal::kConflict;
  } else {
    out.refusal = Refusal::kNone;
  }
  return out;
}

}  // namespace rali::places
