#include "rali/places/recognise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rali::places {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

double turned(const SE3& a, const SE3& b) { return std::abs(wrapped(yaw_of(a.R) - yaw_of(b.R))); }

bool same(const SE3& a, const SE3& b, const RecogniseSettings& s) {
  return (a.p - b.p).norm() < s.apart_m && turned(a, b) < s.apart_deg * kDegree;
}

int agreeing(const Placement& p) {
  return std::min(p.verdict.source_in_target.agree, p.verdict.target_in_source.agree);
}

/// Contradictions weigh more than agreement: a wrong placement agrees too, on its walls. Surfaces
/// that face along the corridor are rare and decide.
double merit(const Placement& p) {
  constexpr double kContradiction = 5.0, kFacing = 3.0;
  const Verdict& v = p.verdict;
  return v.source_in_target.agree + v.target_in_source.agree +
         kFacing * (v.along_in_target.agree + v.along_in_source.agree) -
         kContradiction * (v.source_in_target.conflict + v.target_in_source.conflict);
}

/// Keeps a placement that passes verification if it is new, or better than the one equal to it.
void keep(Placement&& placement, const RecogniseSettings& s, std::vector<Placement>& kept) {
  for (Placement& old : kept) {
    if (!same(old.registration.T_target_source, placement.registration.T_target_source, s)) {
      continue;
    }
    if (merit(placement) > merit(old)) old = std::move(placement);
    return;
  }
  kept.push_back(std::move(placement));
}

/// The horizontal direction in which two placements differ; the least constrained one if their yaws
/// differ.
Vec3 difference(const Placement& best, const Placement& other, const RecogniseSettings& s) {
  const SE3& T = best.registration.T_target_source;
  Vec3 d = other.registration.T_target_source.p - T.p;
  d.z() = 0.0;
  const bool shifted = turned(T, other.registration.T_target_source) < s.apart_deg * kDegree;
  return shifted && d.norm() > 0.5 * s.apart_m ? d.normalized()
                                               : best.registration.directions[0].direction_odom;
}

int facing(const Submap& target, const Submap& source, const SE3& T, const Vec3& axis,
           const VerifySettings& s) {
  const SE3 back = T.inverse();
  return agreement_along(target, source, T, axis, s).agree +
         agreement_along(source, target, back, back.R * axis, s).agree;
}

/// Whether the other placement could be right as well.
bool rivals(const Submap& target, const Submap& source, const Placement& best,
            const Placement& other, const RecogniseSettings& s) {
  if (other.verdict.conflict_fraction() >= best.verdict.conflict_fraction() + s.rival_conflict ||
      agreeing(other) <= s.rival_overlap * agreeing(best)) {
    return false;
  }
  const Vec3 axis = difference(best, other, s);
  const int here = facing(target, source, best.registration.T_target_source, axis, s.verify);
  const int there = facing(target, source, other.registration.T_target_source, axis, s.verify);
  return here < s.facing_decides || there > s.rival_facing * here;
}

bool is_held(const Verdict& v, const RecogniseSettings& s) {
  const int agree = v.along_in_target.agree + v.along_in_source.agree;
  const int asked = v.along_in_target.asked + v.along_in_source.asked;
  return agree >= s.facing_min && agree >= s.facing_fraction * asked;
}

/// The horizontal line through the best placement that holds all rivals, if there is one.
std::optional<Vec3> common_axis(const Placement& best, std::span<const SE3> rivals,
                                const RecogniseSettings& s) {
  const SE3& T = best.registration.T_target_source;
  Vec3 farthest = Vec3::Zero();
  for (const SE3& rival : rivals) {
    const Vec3 d(rival.p.x() - T.p.x(), rival.p.y() - T.p.y(), 0.0);
    if (d.norm() > farthest.norm()) farthest = d;
  }
  if (farthest.norm() < 1e-6) return {};
  const Vec3 axis = farthest.normalized();
  for (const SE3& rival : rivals) {
    const Vec3 d = rival.p - T.p;
    if ((d - axis * axis.dot(d)).norm() > s.along_m) return {};
    if (turned(rival, T) > s.apart_deg * kDegree) return {};
  }
  return axis;
}

/// The line through the rivals and the direction that planes constrain least are one axis estimated
/// twice: the second is more accurate, and the lateral position is known to centimetres.
Vec3 better_bearing(const Vec3& line, const Placement& best) {
  constexpr double kSame = 0.9;  // cosine
  const Vec3& least_known = best.registration.directions[0].direction_odom;
  return std::abs(line.dot(least_known)) > kSame ? least_known : line;
}

/// Takes the position along the axis from the guess and registers the lateral part there, because
/// passages bend.
void leave_open(const Submap& target, const Submap& source, const RecogniseSettings& s,
                const std::optional<Guess>& guess, const Vec3& axis, Recognition& out) {
  Placement& best = out.placements.front();
  SE3 start = best.registration.T_target_source;
  if (guess) start.p += axis * axis.dot(guess->T_target_source.p - start.p);
  best.registration = align(target, source, start, s.align, axis);
  if (best.registration.converged)
    best.verdict = verify(target, source, best.registration, s.verify);
  const bool holds = best.registration.converged && best.verdict.believable();
  out.certainty = holds ? Certainty::kAlongAxis : Certainty::kAmbiguous;
  out.axis_target = axis;
}

/// Compares the best placement with the others and removes information that it cannot support.
void judge(const Submap& target, const Submap& source, const RecogniseSettings& s,
           const std::optional<Guess>& guess, Recognition& out) {
  if (out.placements.empty()) return;
  const Placement& best = out.placements.front();
  std::vector<SE3> others;
  for (std::size_t k = 1; k < out.placements.size(); ++k) {
    if (rivals(target, source, best, out.placements[k], s)) {
      others.push_back(out.placements[k].registration.T_target_source);
    }
  }
  const Verdict& v = best.verdict;
  const bool held = is_held(v, s);
  const int stations = std::min(v.along_in_target.stations, v.along_in_source.stations);
  out.certainty = Certainty::kUnique;
  if (!guess && (!held || stations < s.stations_min)) {
    out.certainty = Certainty::kAmbiguous;
  } else if (!others.empty()) {
    const auto axis = common_axis(best, others, s);
    if (axis) leave_open(target, source, s, guess, better_bearing(*axis, best), out);
    if (!axis) out.certainty = Certainty::kAmbiguous;
  } else if (!held) {
    leave_open(target, source, s, guess, best.registration.directions[0].direction_odom, out);
  }
}

}  // namespace

Recognition recognise_from(const Submap& target, const Submap& source, std::span<const SE3> starts,
                           const RecogniseSettings& s, const std::optional<Guess>& guess) {
  Recognition out;
  for (const SE3& start : starts) {
    Placement p;
    ++out.tried;
    p.registration = align(target, source, start, s.align);
    if (p.registration.converged) {
      const SE3& T = p.registration.T_target_source;
      p.verdict.refusal = Refusal::kOutsideGuess;
      if (!guess || within(*guess, T, s.search.gate)) {
        p.verdict = verify(target, source, p.registration, s.verify);
      }
    }
    out.refusal = std::max(out.refusal, p.verdict.refusal);
    if (p.verdict.believable()) keep(std::move(p), s, out.placements);
  }
  if (out.found()) out.refusal = Refusal::kNone;
  std::stable_sort(out.placements.begin(), out.placements.end(),
                   [](const Placement& a, const Placement& b) { return merit(a) > merit(b); });
  judge(target, source, s, guess, out);
  return out;
}

namespace {

double conflict_at(const Submap& target, const Submap& source, const SE3& T_target_source,
                   const VerifySettings& s) {
  Agreement both = agreement(target, source, T_target_source, s);
  const Agreement back = agreement(source, target, T_target_source.inverse(), s);
  both.agree += back.agree;
  both.conflict += back.conflict;
  return both.agree + both.conflict < s.upright_min ? 0.0 : both.conflict_fraction();
}

/// Offsets of up to 2.5 sigma to either side, small ones first, in steps of `step` if `most` of
/// them reach as far.
std::vector<double> offsets(double sigma, double step, int most) {
  const double reach = 2.5 * sigma;
  const int n =
      static_cast<int>(std::clamp(std::ceil(reach / step), 0.0, static_cast<double>(most)));
  std::vector<double> out{0.0};
  for (int k = 1; k <= n; ++k) {
    out.push_back(reach * k / n);
    out.push_back(-reach * k / n);
  }
  return out;
}

/// The least of all poses that the guess allows: at the guess itself far walls are displaced by
/// metres if its yaw is a sigma off. The first pose with no more than a match may have ends the
/// search: it contradicts nothing.
double least_conflict(const Submap& target, const Submap& source, const Guess& guess,
                      const VerifySettings& s) {
  constexpr double kStep_m = 0.3;
  constexpr double kStep_rad = 1.0 * kDegree;  // 0.35 m, 20 m away
  const geometry::Vec2 sigma_m =
      guess.covariance.block<2, 2>(3, 3).diagonal().cwiseMax(0.0).cwiseSqrt();
  double least = 1.0;
  for (const double yaw_rad : offsets(yaw_sigma_rad(guess), kStep_rad, 10)) {
    SE3 pose = guess.T_target_source;
    pose.R = pose.R * geometry::so3_exp(yaw_rad * Vec3::UnitZ());
    for (const double x_m : offsets(sigma_m.x(), kStep_m, 3)) {
      for (const double y_m : offsets(sigma_m.y(), kStep_m, 3)) {
        pose.p = guess.T_target_source.p + Vec3(x_m, y_m, 0.0);
        least = std::min(least, conflict_at(target, source, pose, s));
        if (least <= s.conflict_max) return least;
      }
    }
  }
  return least;
}

}  // namespace

Recognition recognise(const Submap& target, const Submap& source, const RecogniseSettings& s,
                      const std::optional<Guess>& guess) {
  std::vector<SE3> starts;
  if (guess) starts.push_back(guess->T_target_source);
  const bool tight = guess && horizontal_sigma_m(*guess) < s.tight_m &&
                     yaw_sigma_rad(*guess) < s.tight_deg * kDegree;
  if (!tight) {
    for (const Hypothesis& h : global_hypotheses(target, source, s.search, guess).places) {
      starts.push_back(h.T_a_b);
    }
  }
  Recognition out = recognise_from(target, source, starts, s, guess);
  if (guess && !out.found()) {
    out.conflict_as_guessed = least_conflict(target, source, *guess, s.verify);
  }
  return out;
}

bool may_overlap(const Submap& target, const Submap& source, const Guess& guess,
                 const NearSettings& s) {
  const double sigma_m = horizontal_sigma_m(guess);
  if (!(sigma_m <= s.sigma_max_m)) return false;
  const double reach_m = s.view_m + s.gate * sigma_m;
  const std::span<const geometry::Vec3f> sources = source.views_m();
  return std::any_of(sources.begin(), sources.end(), [&](const geometry::Vec3f& own) {
    const Vec3 from = guess.T_target_source * own.cast<double>();
    const std::span<const geometry::Vec3f> targets = target.views_m();
    return std::any_of(targets.begin(), targets.end(), [&](const geometry::Vec3f& to) {
      return (from - to.cast<double>()).head<2>().norm() <= reach_m;
    });
  });
}

}  // namespace rali::places
