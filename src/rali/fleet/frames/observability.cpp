#include "rali/fleet/frames/observability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

namespace rali::fleet {

using geometry::Vec2;

namespace {

/// A path is straight if it deviates less from its line (algorithms_fleet 7.3, table).
constexpr double kStraight_m = 0.4;
/// Distances that vary by less give little information.
constexpr double kSpread_m = 1.0;
/// Sine of the angle below which two straight paths are parallel.
constexpr double kParallelSine = 0.2;
/// Fraction of heading in the weakest direction above which the heading counts as unknown.
constexpr double kDominates = 0.5;
/// Scaled information below this counts as zero.
constexpr double kNothing = 1e-9;

/// The principal line of one end's path.
struct Line {
  Vec2 along = Vec2::UnitX();
  double length_m = 0.0, width_m = 0.0;

  [[nodiscard]] bool straight() const { return width_m < kStraight_m; }
};

Line line_of(const std::vector<PlanarRange>& ranges, bool of_x) {
  Line line;
  if (ranges.empty()) return line;
  Vec2 mean = Vec2::Zero();
  const auto point = [of_x](const PlanarRange& r) { return of_x ? r.x_m : r.y_m; };
  for (const PlanarRange& r : ranges) mean += point(r) / static_cast<double>(ranges.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const PlanarRange& r : ranges) {
    const Vec2 d = point(r) - mean;
    spread += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread);
  line.along = solver.eigenvectors().col(1);
  const auto extent = [&](const Vec2& axis) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const PlanarRange& r : ranges) {
      low = std::min(low, axis.dot(point(r)));
      high = std::max(high, axis.dot(point(r)));
    }
    return high - low;
  };
  line.length_m = extent(line.along);
  line.width_m = extent(solver.eigenvectors().col(0));
  return line;
}

double spread_of_distances_m(const std::vector<PlanarRange>& ranges) {
  if (ranges.empty()) return 0.0;
  const auto [low, high] =
      std::minmax_element(ranges.begin(), ranges.end(),
                          [](const auto& p, const auto& q) { return p.range_m < q.range_m; });
  return high->range_m - low->range_m;
}

bool parallel(const Line& x, const Line& y, double yaw_rad) {
  const Vec2 turned(std::cos(yaw_rad) * x.along.x() - std::sin(yaw_rad) * x.along.y(),
                    std::sin(yaw_rad) * x.along.x() + std::cos(yaw_rad) * x.along.y());
  return std::abs(turned.x() * y.along.y() - turned.y() * y.along.x()) < kParallelSine;
}

/// Reason why several poses fit.
Advice why_rivals(const HypothesisSet& set, const Line& x, const Line& y,
                  const InitSettings& settings) {
  const bool one_stands = set.a_stands || set.b_stands;
  if (set.ranges.empty()) {
    const bool sure = set.all[0].views > 0 && set.all[1].views > 0;
    return sure ? Advice::kContradict : Advice::kLookAlike;
  }
  if (set.a_stands && set.b_stands) return Advice::kDistance;
  if (one_stands) {
    const Line& moving = set.b_stands ? x : y;
    return moving.straight() ? Advice::kMirror : Advice::kSeveral;
  }
  if (x.straight() && y.straight()) {
    const bool side_by_side = parallel(x, y, set.all.front().T_b_a.yaw_rad);
    return side_by_side ? Advice::kParallel : Advice::kMirror;
  }
  const double turn = wrapped(set.all[1].T_b_a.yaw_rad - set.all[0].T_b_a.yaw_rad);
  const bool other_heading = std::abs(turn) > settings.search.merge_deg * kDegree;
  if (other_heading && !x.straight() && !y.straight()) return Advice::kAlike;
  return Advice::kSeveral;
}

/// One pose fits, but a direction is not constrained well enough.
Advice why_weak(const HypothesisSet& set, const Observability& seen, const Line& x, const Line& y,
                const InitSettings& settings) {
  if (set.ranges.empty()) return Advice::kSlides;
  if (set.a_stands && set.b_stands) return Advice::kDistance;
  const double heading_fraction = seen.eigenvectors(0, 0) * seen.eigenvectors(0, 0);
  const bool stands = set.a_stands || set.b_stands;
  if (stands && (heading_fraction > kDominates || !seen.heading_known))
    return Advice::kHeadingUnknown;
  if (!stands && x.straight() && y.straight() && parallel(x, y, set.all.front().T_b_a.yaw_rad)) {
    return Advice::kParallel;
  }
  if (spread_of_distances_m(set.ranges) < kSpread_m) return Advice::kDistance;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      scaled_planar_information(set.all.front().offset_information, settings.commit),
      Eigen::EigenvaluesOnly);
  const bool by_offset = solver.eigenvalues()[0] >= settings.commit.information_min;
  return by_offset ? Advice::kOffset : Advice::kNotYet;
}

/// Sigmas with drift included: of yaw, and of the worse axis of the position.
void set_sigmas(const Mat4& information, const CommitSettings& settings, Observability& seen) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      scaled_planar_information(information, settings));
  const Eigen::Vector3d variances = solver.eigenvalues().cwiseMax(kNothing).cwiseInverse();
  const Eigen::Matrix3d C =
      solver.eigenvectors() * variances.asDiagonal() * solver.eigenvectors().transpose();
  seen.yaw_sigma_rad = settings.yaw_unit_deg * kDegree * std::sqrt(C(0, 0));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> place(
      Eigen::Matrix2d(C.bottomRightCorner<2, 2>()), Eigen::EigenvaluesOnly);
  seen.place_sigma_m = settings.place_unit_m * std::sqrt(place.eigenvalues()[1]);
}

/// With evidence from scans only, driving on in the same direction adds no information.
std::string by_scans_text(Advice advice, const Observability& seen, const std::string& a,
                          const std::string& b) {
  if (advice == Advice::kContradict) {
    return fmt::format(
        "{}: places recognised in the map of {} contradict each other by {:.1f} m and {:.1f} deg: "
        "the odometry error exceeds its sigma, or one of them is another place. Give a start pose "
        "(priors), or leave out where the sensor started in motion (start_s)",
        a, b, seen.rival_m, seen.rival_rad / kDegree);
  }
  const std::string why =
      advice == Advice::kSlides
          ? fmt::format("its scans fit everywhere along the path of {}; scans alone cannot decide",
                        b)
          : fmt::format("{} places against {} look alike; scans alone cannot decide",
                        seen.rivals + 1, b);
  return fmt::format(
      "{}: {}. Let both see a place that is like no other, or give a start pose (priors)", a, why);
}

/// One pose is left and observable, but another condition prevents the commit.
std::string refusal_text(Advice advice, const Observability& seen, const std::string& a,
                         const std::string& b, const InitSettings& settings) {
  switch (advice) {
    case Advice::kMisfit:
      return fmt::format("{}: ranges to {} contradict the odometry of both, no place fits", a, b);
    case Advice::kTooGood:
      return fmt::format("{}: ranges to {} are better than their sigma; give a smaller one", a, b);
    case Advice::kNoPrior:
      return fmt::format("{}: needs a start pose against {} (preset paper)", a, b);
    case Advice::kSmallMap:
      return fmt::format("{}: waiting for keyframes (at least {})", a,
                         settings.commit.min_keyframes);
    case Advice::kFewViews:
      return fmt::format("{}: fewer than {} places recognised that {} saw, too. Let it see more", a,
                         settings.commit.views_min, b);
    case Advice::kDrift:
      return fmt::format(
          "{}: odometry drifts too much: place against {} known to {:.0f} deg and {:.1f} m only", a,
          b, seen.yaw_sigma_rad / kDegree, seen.place_sigma_m);
    default:
      return {};
  }
}

}  // namespace

Eigen::Matrix3d scaled_planar_information(const Mat4& information, const CommitSettings& settings) {
  Eigen::Matrix3d I = information.topLeftCorner<3, 3>();
  const Eigen::Vector3d with_z = information.topRightCorner<3, 1>();
  if (information(3, 3) > 0.0) I -= with_z * with_z.transpose() / information(3, 3);
  const Eigen::Vector3d unit(settings.yaw_unit_deg * kDegree, settings.place_unit_m,
                             settings.place_unit_m);
  return unit.asDiagonal() * I * unit.asDiagonal();
}

Observability observability(const HypothesisSet& set, const InitSettings& settings) {
  Observability seen;
  seen.ranges = static_cast<int>(set.ranges.size());
  seen.a_stands = set.a_stands;
  seen.b_stands = set.b_stands;
  if (set.all.empty()) return seen;
  const FrameHypothesis& best = set.all.front();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      scaled_planar_information(best.drift_information, settings.commit));
  seen.eigenvalues = solver.eigenvalues();
  seen.eigenvectors = solver.eigenvectors();
  // Information on z given all else bounds sigma from below; ranges hardly correlate z with the
  // rest.
  seen.z_sigma_m = best.information(3, 3) > 0.0 ? 1.0 / std::sqrt(best.information(3, 3))
                                                : std::numeric_limits<double>::infinity();
  set_sigmas(best.information, settings.commit, seen);
  const double minimum = settings.commit.information_min;
  const bool exact = seen.yaw_sigma_rad <= settings.commit.yaw_sigma_max_deg * kDegree &&
                     seen.place_sigma_m <= settings.commit.place_sigma_max_m;
  seen.sufficient =
      seen.eigenvalues[0] >= minimum && exact && seen.z_sigma_m <= settings.commit.z_sigma_max_m;
  // Yaw alone: its variance is finite only if no unobservable direction contains rotation.
  seen.heading_known = true;
  for (int k = 0; k < 3; ++k) {
    if (seen.eigenvalues[k] < minimum && std::abs(seen.eigenvectors(0, k)) > 0.1) {
      seen.heading_known = false;
    }
  }
  for (std::size_t k = 1; k < set.all.size(); ++k) {
    if (set.gap(k) <= settings.commit.gap_chi2) ++seen.rivals;
  }
  if (seen.rivals > 0) {
    seen.rival_m = (set.all[1].place_b_m() - best.place_b_m()).norm();
    seen.rival_rad = std::abs(wrapped(set.all[1].T_b_a.yaw_rad - best.T_b_a.yaw_rad));
  }
  const bool scans = std::any_of(best.solution.holds.begin(), best.solution.holds.end(),
                                 [](int k) { return k >= 0; });
  const Line x = line_of(set.ranges, true);
  const Line y = line_of(set.ranges, false);
  if (!scans && seen.ranges < settings.commit.min_ranges) {
    seen.advice = seen.ranges == 0 ? Advice::kNoContact : Advice::kWaiting;
  } else if (seen.rivals > 0) {
    seen.advice = why_rivals(set, x, y, settings);
  } else if (seen.eigenvalues[0] < minimum) {
    seen.advice = why_weak(set, seen, x, y, settings);
  } else if (!exact) {
    seen.advice = Advice::kDrift;
  } else {
    seen.advice = seen.sufficient ? Advice::kEnough : Advice::kHeight;
  }
  return seen;
}

std::string advice_text(Advice advice, const Observability& seen, const std::string& a,
                        const std::string& b, const InitSettings& settings) {
  const std::string& stands = seen.b_stands || !seen.a_stands ? b : a;
  const std::string& moves = seen.b_stands || !seen.a_stands ? a : b;
  switch (advice) {
    case Advice::kEnough:
      return fmt::format("{}: place against {} is known", a, b);
    case Advice::kNoContact:
      return fmt::format("{}: neither ranges nor common places with {} yet", a, b);
    case Advice::kWaiting:
      return fmt::format("{}: waiting for ranges ({} of {})", a, seen.ranges,
                         settings.commit.min_ranges);
    case Advice::kHeadingUnknown:
      return fmt::format(
          "{}: heading against {} unknown; ranges to a standing vehicle cannot give it. Let {} see "
          "{}'s mapped area, or move {} 2 m off its place",
          a, b, b, a, stands);
    case Advice::kMirror:
      return fmt::format("{}: left/right of {} unknown. Move {} off its line by 1 m", a, b, moves);
    case Advice::kParallel:
      return fmt::format("{} and {} drive in parallel: turn one of them", b, a);
    case Advice::kAlike:
      return fmt::format("{} and {} drive alike: let one of them turn the other way", b, a);
    case Advice::kDistance:
      return fmt::format("{}: distance to {} does not change. Move {} towards or away from {}", a,
                         b, moves, stands);
    case Advice::kOffset:
      return fmt::format(
          "{}: radio offset of pair {}-{} not separable (+-{:.2f} m). Pass {} once, or calibrate",
          a, b, a, settings.bias_sigma_m, b);
    case Advice::kSeveral:
      return fmt::format("{}: {} places against {} fit alike. Drive on, and turn", a,
                         seen.rivals + 1, b);
    case Advice::kLookAlike:
    case Advice::kContradict:
    case Advice::kSlides:
      return by_scans_text(advice, seen, a, b);
    case Advice::kNotYet:
      return fmt::format("{}: place against {} not known well enough yet. Drive on", a, b);
    case Advice::kHeight:
      return fmt::format("{}: height against {} unknown (+-{:.1f} m). Let {} see {}'s mapped area",
                         a, b, seen.z_sigma_m, b, a);
    case Advice::kMisfit:
    case Advice::kTooGood:
    case Advice::kNoPrior:
    case Advice::kSmallMap:
    case Advice::kFewViews:
    case Advice::kDrift:
      return refusal_text(advice, seen, a, b, settings);
  }
  return {};
}

}  // namespace rali::fleet
