#include "rali/places/hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "rali/places/correlator.hpp"

namespace rali::places {

using geometry::SE3;
using geometry::Vec2;
using geometry::Vec3;

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kMore = 0.5;  ///< sigma more, before the peaks are refined

/// Products per yaw up to which the shifts within a guess are summed directly: an FFT over all
/// shifts costs as much as 3e6 (200 marks) to 2e7 of them (600).
constexpr double kProductsMax = 4e6;

bool stronger(const Place& a, const Place& b) {
  if (a.correlation != b.correlation) return a.correlation > b.correlation;
  if (a.yaw_rad != b.yaw_rad) return a.yaw_rad < b.yaw_rad;
  if (a.shift_m.x() != b.shift_m.x()) return a.shift_m.x() < b.shift_m.x();
  return a.shift_m.y() < b.shift_m.y();
}

/// Hill climbing on the finer picture.
void refine(const Picture& picture, std::span<const Mark> marks, double cell_m, double yaw_step,
            Place& place) {
  place.correlation = correlation(picture, marks, place.yaw_rad, place.shift_m);
  double turn = 0.5 * yaw_step;
  double step_m = 2.0 * cell_m;
  for (int round = 0; round < 3; ++round, turn *= 0.5, step_m *= 0.5) {
    for (int tries = 0; tries < 4; ++tries) {
      const Place from = place;
      for (int k = 0; k < 6; ++k) {
        Place next = from;
        const double sign = k % 2 == 0 ? 1.0 : -1.0;
        if (k < 2) next.yaw_rad += sign * turn;
        if (k >= 2 && k < 4) next.shift_m.x() += sign * step_m;
        if (k >= 4) next.shift_m.y() += sign * step_m;
        next.correlation = correlation(picture, marks, next.yaw_rad, next.shift_m);
        if (next.correlation > place.correlation) place = next;
      }
      if (place.correlation <= from.correlation) break;
    }
  }
}

class Search {
 public:
  Search(const Submap& a, const Submap& b, const HypothesisSettings& s,
         const std::optional<Guess>& guess)
      : a_(a),
        s_(s),
        guess_(guess),
        height_m_(a.ground_z_m() - b.ground_z_m()),
        coarse_m_(2.0 * s.cell_m),
        coarse_marks_(marks_of(b, coarse_m_, s.band)),
        marks_(marks_of(b, s.cell_m, s.band)),
        coarse_(marks_of(a, coarse_m_, s.band), coarse_m_),
        fine_(marks_of(a, s.cell_m, s.band), s.cell_m) {}

  Hypotheses run();

 private:
  [[nodiscard]] std::vector<double> yaws() const;
  [[nodiscard]] std::optional<ShiftWindow> window() const;
  [[nodiscard]] std::vector<Place> coarse_peaks() const;

  [[nodiscard]] SE3 pose(const Place& p) const {
    return {geometry::rotation_from_rpy(0.0, 0.0, p.yaw_rad),
            {p.shift_m.x(), p.shift_m.y(), height_m_}};
  }

  [[nodiscard]] bool allowed(const Place& p, double more) const {
    return !guess_ || within(*guess_, pose(p), s_.gate + more);
  }

  [[nodiscard]] bool is_new(const Place& p, const std::vector<Place>& kept) const;
  std::vector<Place> distinct(std::vector<Place> found) const;
  [[nodiscard]] Vec2 weakest_direction() const;
  void add_ridge(const Place& best, Hypotheses& out) const;

  const Submap& a_;
  const HypothesisSettings& s_;
  const std::optional<Guess>& guess_;
  double height_m_, coarse_m_;
  std::vector<Mark> coarse_marks_, marks_;
  Picture coarse_, fine_;
};

std::vector<double> Search::yaws() const {
  const int n = std::max(2, static_cast<int>(std::lround(360.0 / s_.yaw_step_deg)));
  std::vector<double> out;
  for (int k = 0; k < n; ++k) {
    const double yaw = kTurn * k / n;
    const double off = guess_ ? wrapped(yaw - yaw_of(guess_->T_target_source.R)) : 0.0;
    if (guess_ && std::abs(off) > s_.gate * yaw_sigma_rad(*guess_) + kTurn / n) continue;
    out.push_back(yaw);
  }
  return out;
}

bool Search::is_new(const Place& p, const std::vector<Place>& kept) const {
  return std::none_of(kept.begin(), kept.end(), [&](const Place& q) {
    return (p.shift_m - q.shift_m).norm() < s_.apart_m &&
           std::abs(wrapped(p.yaw_rad - q.yaw_rad)) < s_.apart_deg * kTurn / 360.0;
  });
}

std::vector<Place> Search::distinct(std::vector<Place> found) const {
  std::sort(found.begin(), found.end(), stronger);
  std::vector<Place> kept;
  for (const Place& p : found) {
    if (static_cast<int>(kept.size()) >= s_.peaks_max) break;
    if (!kept.empty() && p.correlation < s_.min_fraction * kept.front().correlation) break;
    if (is_new(p, kept)) kept.push_back(p);
  }
  return kept;
}

/// Horizontal direction that the target's walls constrain least.
Vec2 Search::weakest_direction() const {
  Eigen::Matrix2d N = Eigen::Matrix2d::Zero();
  for (const Plane& plane : a_.planes()) {
    if (!plane.is_wall()) continue;
    const Vec2 n = plane.n.head<2>();
    N += plane.radius_m * plane.radius_m * n * n.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(N).eigenvectors().col(0);
}

void Search::add_ridge(const Place& best, Hypotheses& out) const {
  const Vec2 d = weakest_direction();
  const int reach = static_cast<int>(s_.ridge_reach_m / s_.ridge_step_m);
  Ridge ridge{pose(best), Vec3(d.x(), d.y(), 0.0), 0.0, 0.0};
  std::vector<Place> along;
  for (const int sign : {1, -1}) {
    for (int k = 1; k <= reach; ++k) {
      Place p = best;
      p.shift_m += sign * k * s_.ridge_step_m * d;
      p.correlation = correlation(fine_, marks_, p.yaw_rad, p.shift_m);
      // Farther along, the overlap shrinks and with it the correlation: the full threshold applies
      // only to the first 3 m.
      if (k * s_.ridge_step_m <= 3.0 && p.correlation < s_.ridge_fraction * best.correlation) break;
      if (p.correlation < 0.5 * s_.ridge_fraction * best.correlation) break;
      (sign > 0 ? ridge.to_m : ridge.from_m) = sign * k * s_.ridge_step_m;
      if (allowed(p, 0.0)) along.push_back(p);
    }
  }
  if (ridge.to_m - ridge.from_m < 4.0) return;  // a room's wall also matches over a metre or two
  out.ridges.push_back(ridge);
  for (const Place& p : along) out.places.push_back({pose(p), p.correlation, true});
}

/// The window of the guess, if it is small enough to search directly.
std::optional<ShiftWindow> Search::window() const {
  if (!guess_) return std::nullopt;
  const Vec2 reach_m = reach_m_of(*guess_, s_.gate + kMore);
  const Vec2 middle_m = guess_->T_target_source.p.head<2>();
  const ShiftWindow window{middle_m - reach_m, middle_m + reach_m};
  const double products = window.count(coarse_m_) * static_cast<double>(coarse_marks_.size());
  return products <= kProductsMax ? std::optional(window) : std::nullopt;
}

std::vector<Place> Search::coarse_peaks() const {
  std::vector<Place> found;
  const std::vector<double> turns = yaws();
  if (const auto shifts = window()) {
    for (const double yaw_rad : turns) {
      correlate_within(coarse_, coarse_marks_, coarse_m_, yaw_rad, *shifts, found);
    }
    return found;
  }
  Correlator correlator(coarse_, coarse_marks_, coarse_m_);
  // An odd last yaw is correlated twice: the equal places are merged later.
  for (std::size_t k = 0; k < turns.size(); k += 2) {
    correlator.correlate(turns[k], turns[std::min(k + 1, turns.size() - 1)], found);
  }
  return found;
}

Hypotheses Search::run() {
  Hypotheses out;
  if (marks_.empty() || fine_.cells().empty()) return out;
  std::vector<Place> found = coarse_peaks();
  std::erase_if(found, [&](const Place& p) { return !allowed(p, kMore); });
  std::vector<Place> peaks = distinct(std::move(found));
  for (Place& p : peaks) {
    refine(fine_, marks_, s_.cell_m, s_.yaw_step_deg * kTurn / 360.0, p);
  }
  peaks = distinct(std::move(peaks));
  for (const Place& p : peaks) out.places.push_back({pose(p), p.correlation, false});
  if (peaks.empty()) return out;
  add_ridge(peaks.front(), out);
  const auto twin = std::find_if(peaks.begin(), peaks.end(), [&](const Place& p) {
    return std::abs(wrapped(p.yaw_rad - peaks.front().yaw_rad)) > 0.75 * std::numbers::pi;
  });
  if (twin != peaks.end()) add_ridge(*twin, out);
  return out;
}

}  // namespace

Hypotheses global_hypotheses(const Submap& a, const Submap& b, const HypothesisSettings& settings,
                             const std::optional<Guess>& guess) {
  return Search(a, b, settings, guess).run();
}

}  // namespace rali::places
