#include "rali/places/align.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "rali/geometry/robust.hpp"
#include "rali/places/partners.hpp"

namespace rali::places {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kStop_m = 2e-4;
constexpr double kStop_rad = 2e-5;

/// The prior of the start, in boxplus order: rotation in source, translation in target.
Mat6 start_information(const AlignSettings& s) {
  const double level = 1.0 / std::pow(s.level_sigma_deg * kDegree, 2);
  const double yaw = 1.0 / std::pow(s.start_sigma_deg * kDegree, 2);
  const double place = 1.0 / std::pow(s.start_sigma_m, 2);
  Vec6 d;
  d << level, level, yaw, place, place, place;
  return d.asDiagonal();
}

/// One Gauss-Newton step from T towards partners and start; returns its length (rad, m).
std::pair<double, double> step(const System& system, const SE3& start, const Mat6& P_inverse,
                               SE3& T) {
  const Vec6 from_start = geometry::boxminus(T, start);
  const Mat6 A = system.I + P_inverse;
  Vec6 d = -A.ldlt().solve(system.b + P_inverse * from_start);
  if (!d.allFinite()) return {0.0, 0.0};
  const double length = d.tail<3>().norm();
  const double angle = d.head<3>().norm();
  const double shrink = std::min({1.0, 1.0 / std::max(length, 1e-9), 0.2 / std::max(angle, 1e-9)});
  d *= shrink;
  T = geometry::boxplus(T, d);
  return {angle, length};
}

degeneracy::Axes axes_at(const System& system, const Mat3& R,
                         const degeneracy::AwareSettings& aware) {
  return degeneracy::physical_axes(system.I, Vec3(0.0, 0.0, -1.0), R, Mat3::Identity(), aware);
}

/// Removes the spurious information from noise of normals, so that no step is taken along a
/// degenerate direction.
std::array<degeneracy::DirectionInfo, 6> clean(const Partners& partners, const Mat3& R,
                                               const degeneracy::AwareSettings& aware,
                                               System& system) {
  const auto directions = degeneracy::direction_information(system.I, partners.evidence(), R,
                                                            axes_at(system, R, aware), aware);
  degeneracy::remove_spurious(system.I, system.b, R, directions);
  return directions;
}

/// Removes what the planes say about the motion along a direction that the caller knows to be open.
/// In a bend that motion is a screw: with the translation alone removed, the noise of the planes
/// would determine the yaw, and with it where in the bend the submap lies.
void leave_open(const std::optional<Vec3>& open, const Mat3& R, System& system) {
  if (!open) return;
  const Vec3 side = Vec3::UnitZ().cross(*open).normalized();
  degeneracy::Axes axes;
  axes << *open, side, open->cross(side);
  const Vec6 u = degeneracy::least_motion(system.I, 0, R, axes);
  const Vec6 Iu = system.I * u;
  const double along = u.dot(Iu);
  if (along <= 0.0) return;
  system.b -= u.dot(system.b) / along * Iu;
  system.I -= Iu * Iu.transpose() / along;
}

/// (I^-1 + S)^-1 without inverting I: what was zero stays zero.
Mat6 with_shared_errors(const Mat6& I, const Vec6& variance) {
  Mat6 sum = I;
  sum.diagonal() += variance.cwiseInverse();
  const Mat6 out = I - I * sum.ldlt().solve(I);
  return 0.5 * (out + out.transpose());
}

degeneracy::Category category_of(double sigma, double full, double none) {
  if (sigma < full) return degeneracy::Category::kFull;
  return sigma > none ? degeneracy::Category::kNone : degeneracy::Category::kPartial;
}

void finish(const System& system, double shared_m, const AlignSettings& s, Registration& out) {
  const double shared_rad = s.shared_sigma_deg * kDegree;
  Vec6 variance;
  variance << Vec3::Constant(std::max(1e-12, shared_rad * shared_rad)),
      Vec3::Constant(std::max(1e-10, shared_m * shared_m));
  out.information = with_shared_errors(system.I, variance);
  for (std::size_t k = 0; k < 6; ++k) {
    degeneracy::DirectionInfo& d = out.directions[k];
    d.sigma = std::hypot(d.sigma, k < 3 ? shared_m : shared_rad);
    d.information = std::isfinite(d.sigma) ? 1.0 / (d.sigma * d.sigma) : 0.0;
    d.category = k < 3
                     ? category_of(d.sigma, s.aware.full_m, s.aware.none_m)
                     : category_of(d.sigma, s.aware.full_deg * kDegree, s.aware.none_deg * kDegree);
  }
}

void pass(const Submap& target, const SE3& start, const AlignSettings& s,
          const std::optional<Vec3>& open, const Gate& gate, Partners& partners, SE3& T) {
  const Mat6 P_inverse = start_information(s);
  for (int k = 0; k < s.iterations; ++k) {
    partners.find(target, T, gate);
    System system = partners.accumulate(target, T);
    leave_open(open, T.R, system);
    if (gate.fine) clean(partners, T.R, s.aware, system);
    const auto [angle, length] = step(system, start, P_inverse, T);
    const double fraction = gate.fine ? 1.0 : 20.0;  // the next pass refines it
    if (length < fraction * kStop_m && angle < fraction * kStop_rad) break;
  }
}

}  // namespace

namespace {

/// With their wide gates the first passes drift along directions that no plane constrains. This
/// moves the estimate back to the start along those directions, because its lateral part was fitted
/// elsewhere.
/// @return the largest shift
double slide_back(const std::array<degeneracy::DirectionInfo, 6>& directions, const SE3& start,
                  SE3& T) {
  double slid_m = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (directions[k].information > 0.0) continue;
    const Vec3& d = directions[k].direction_odom;
    const double along_m = d.dot(T.p - start.p);
    T.p -= along_m * d;
    slid_m = std::max(slid_m, std::abs(along_m));
  }
  return slid_m;
}

}  // namespace

bool Registration::full_rank() const {
  return converged && std::all_of(directions.begin(), directions.end(), [](const auto& d) {
           return d.category == degeneracy::Category::kFull;
         });
}

Registration align(const Submap& target, const Submap& source, const SE3& start,
                   const AlignSettings& s, const std::optional<Vec3>& open) {
  Registration out;
  out.T_target_source = start;
  if (target.planes().empty() || source.planes().empty()) return out;
  if (!start.R.allFinite() || !start.p.allFinite()) return out;
  SE3 T = start;
  Partners partners(s);
  partners.set_source(source.planes(), s.coarse_planes);
  pass(target, start, s, open, {s.coarse_m, s.coarse_m, false}, partners, T);
  pass(target, start, s, open, {0.5 * s.coarse_m, 0.5 * s.coarse_m, false}, partners, T);
  partners.set_source(source.planes(), 2 * s.coarse_planes);
  pass(target, start, s, open, {s.middle_m, s.middle_m, false}, partners, T);
  partners.set_source(source.planes(), std::numeric_limits<int>::max());
  pass(target, start, s, open, {s.middle_m, 0.5 * s.middle_m, true}, partners, T);
  System system;
  const auto look = [&] {
    partners.find(target, T, {s.middle_m, 0.5 * s.middle_m, true});
    system = partners.accumulate(target, T);
    leave_open(open, T.R, system);
    out.directions = clean(partners, T.R, s.aware, system);
  };
  look();
  constexpr double kSlid_m = 0.05;
  if (slide_back(out.directions, start, T) > kSlid_m) {
    pass(target, start, s, open, {s.middle_m, 0.5 * s.middle_m, true}, partners, T);
    look();
  }
  const double path_m = std::max(target.path_m(), source.path_m());
  finish(system, std::hypot(s.shared_sigma_m, s.shared_per_m * path_m), s, out);
  out.T_target_source = {geometry::so3_normalised(T.R), T.p};
  out.matches = system.matches;
  out.overlap = static_cast<double>(system.matches) / static_cast<double>(source.planes().size());
  out.rms_m = system.weight_sum > 0.0 ? std::sqrt(system.square_sum_m2 / system.weight_sum) : 0.0;
  const Vec6 last = (system.I + start_information(s))
                        .ldlt()
                        .solve(system.b + start_information(s) * geometry::boxminus(T, start));
  out.converged = out.matches >= 6 && last.allFinite() && last.tail<3>().norm() < 0.01 &&
                  last.head<3>().norm() < 0.1 * kDegree;
  return out;
}

BodyRelation between_bodies(const Registration& r, const Submap& target, const Submap& source) {
  // Both origins are those of the bodies: only the axes differ.
  const Mat3& Rt = target.T_ref_body().R;
  const Mat3& Rs = source.T_ref_body().R;
  BodyRelation out;
  out.T_target_source = target.T_ref_body().inverse() * r.T_target_source * source.T_ref_body();
  Mat6 G = Mat6::Zero();  // ref residual = G * body residual
  G.topLeftCorner<3, 3>() = Rs;
  G.bottomRightCorner<3, 3>() = Rt;
  out.information = G.transpose() * r.information * G;
  return out;
}

}  // namespace rali::places
