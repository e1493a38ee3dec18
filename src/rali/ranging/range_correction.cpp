#include "rali/ranging/range_correction.hpp"

#include <cmath>

namespace rali::ranging {

using geometry::Vec3;

namespace {

/// Circle and line: the position is c from the anchor and may move along e.
struct Geometry {
  Vec3 c;
  Vec3 e;
  double u_m;  ///< radius
};

/// Steps 2 and 3: into the plane, unless `3d`. Nothing if the range is shorter than the height.
std::optional<Geometry> prepare(const CorrectionInput& in, PaperRange2d range_2d, const Vec3& e) {
  Geometry g{in.p_m - in.anchor_m, e, in.range_m};
  if (range_2d == PaperRange2d::k3d) return g;
  const double dz = g.c.z();
  g.c.z() = 0.0;
  if (range_2d == PaperRange2d::kFlat) return g;
  const double square = g.u_m * g.u_m - dz * dz;
  if (square < 0.0) return std::nullopt;
  g.u_m = std::sqrt(square);
  return g;
}

std::optional<Vec3> direction_of(const Vec3& e3, const PaperRangeSettings& settings) {
  if (settings.range_2d != PaperRange2d::k3d) {
    return horizontal_direction(e3, settings.min_horizontal);
  }
  const double norm = e3.norm();
  if (!(norm > 0.0) || !std::isfinite(norm)) return std::nullopt;
  return Vec3(e3 / norm);
}

Correction accept(Correction out, double s, const Vec3& e, const PaperRangeSettings& settings) {
  if (std::abs(s) > settings.max_s_m) {
    out.outcome = CorrectionOutcome::kTooFar;
    return out;
  }
  out.outcome = CorrectionOutcome::kCorrected;
  out.s_m = s;
  out.shift_m = s * e;
  return out;
}

/// Step 5 with D <= 0: the circle touches the line or does not reach it.
Correction go_closest(Correction out, const Geometry& g, bool touches,
                      const PaperRangeSettings& settings) {
  const double b = g.c.dot(g.e);
  const double miss_m = (g.c - b * g.e).norm() - g.u_m;
  const bool allowed = settings.no_root == PaperNoRoot::kClosest && miss_m <= settings.gap_m;
  if (!touches && !allowed) {
    out.outcome = CorrectionOutcome::kInconsistent;
    return out;
  }
  out.closest = true;
  out.sensitivity = std::numeric_limits<double>::infinity();
  return accept(out, -b, g.e, settings);
}

/// Steps 5 and 6 with two solutions -b -+ root.
Correction choose_root(Correction out, const Geometry& g, double root, const CorrectionInput& in,
                       const PaperRangeSettings& settings) {
  const double b = g.c.dot(g.e);
  const double back = -b - root;
  const double ahead = -b + root;
  out.sensitivity = g.u_m / root;
  double s = std::abs(back) < std::abs(ahead) ? back : ahead;
  if (settings.root == PaperRoot::kNearestImu && in.imu_s_m) {
    s = std::abs(back - *in.imu_s_m) < std::abs(ahead - *in.imu_s_m) ? back : ahead;
  } else if (std::abs(std::abs(back) - std::abs(ahead)) <
             settings.ambiguous_sigmas * settings.range_sigma_m) {
    out.outcome = CorrectionOutcome::kAmbiguous;
    return out;
  }
  if (out.sensitivity > settings.max_sensitivity) {
    out.outcome = CorrectionOutcome::kTooSensitive;
    return out;
  }
  return accept(out, s, g.e, settings);
}

std::vector<double> fraction(std::span<const double> increments, double total_shift, double R) {
  double all = R;
  for (const double c : increments) all += c;
  std::vector<double> out(increments.size(), 0.0);
  if (!(all > 0.0)) return out;
  double sum = 0.0;
  for (std::size_t i = 0; i < increments.size(); ++i) {
    sum += increments[i];
    out[i] = sum / all * total_shift;
  }
  return out;
}

}  // namespace

std::optional<Vec3> horizontal_direction(const Vec3& e3, double minimum) {
  const double all = e3.norm();
  const Vec3 flat(e3.x(), e3.y(), 0.0);
  const double norm = flat.norm();
  if (!std::isfinite(all) || !(norm > 0.0) || norm < minimum * all) return std::nullopt;
  return Vec3(flat / norm);
}

Correction correct_on_circle(const CorrectionInput& input, const PaperRangeSettings& settings) {
  Correction out;
  if (!input.degenerate) return out;
  out.outcome = CorrectionOutcome::kInconsistent;
  if (!input.p_m.allFinite() || !input.anchor_m.allFinite() || !(input.range_m > 0.0) ||
      !std::isfinite(input.range_m)) {
    return out;
  }
  const std::optional<Vec3> e = direction_of(input.e3, settings);
  if (!e) {
    out.outcome = CorrectionOutcome::kDirectionUnknown;
    return out;
  }
  const std::optional<Geometry> g = prepare(input, settings.range_2d, *e);
  if (!g) return out;
  out.gap_m = std::abs(g->c.norm() - g->u_m);
  if (out.gap_m <= settings.gap_m) {
    out.outcome = CorrectionOutcome::kNotNeeded;
    return out;
  }
  const double b = g->c.dot(g->e);
  const double D = b * b - (g->c.squaredNorm() - g->u_m * g->u_m);
  if (D > 0.0) return choose_root(out, *g, std::sqrt(D), input, settings);
  return go_closest(out, *g, D == 0.0, settings);
}

std::vector<double> share_shift(std::span<const double> variance_increments_m2, double shift_m) {
  return fraction(variance_increments_m2, shift_m, 0.0);
}

}  // namespace rali::ranging
