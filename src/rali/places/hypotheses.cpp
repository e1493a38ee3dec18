#include "rali/places/hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "rali/places/fft.hpp"

namespace rali::places {

using geometry::SE3;
using geometry::Vec2;
using geometry::Vec3;

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::size_t kSidesMost = 512;
constexpr std::size_t kPerYaw = 40;  // peaks of one yaw that are looked at

struct Place {
  double yaw_rad = 0.0;
  Vec2 shift_m = Vec2::Zero();
  double correlation = 0.0;
};

/// Farthest mark from the middle, in cells.
std::size_t reach_of(std::span<const Mark> marks, double cell_m) {
  double reach_m = 0.0;
  for (const Mark& m : marks) {
    reach_m = std::max(reach_m, std::hypot(static_cast<double>(m.x_m), static_cast<double>(m.y_m)));
  }
  return std::min(kSidesMost / 2 - 2, static_cast<std::size_t>(reach_m / cell_m) + 1);
}

std::size_t side_for(const Picture& picture, std::size_t reach) {
  const std::size_t cells =
      static_cast<std::size_t>(std::max(picture.nx(), picture.ny())) + 2 * reach + 2;
  std::size_t side = 32;
  while (side < cells && side < kSidesMost) side *= 2;
  return side;
}

/// Correlates rotated marks with one picture, two yaws per transform: one in the real part.
class Correlator {
 public:
  Correlator(const Picture& picture, std::span<const Mark> marks, double cell_m);

  /// Peaks of both yaws are appended.
  void correlate(double yaw1_rad, double yaw2_rad, std::vector<Place>& out);

 private:
  void draw(double yaw_rad, bool imaginary);
  void peaks(double yaw_rad, bool imaginary, std::vector<Place>& out) const;

  [[nodiscard]] float value(std::size_t x, std::size_t y, bool imaginary) const {
    const Fft2::Complex& c = work_[(y & mask_) * fft_.side() + (x & mask_)];
    return imaginary ? c.imag() : c.real();
  }

  /// The transform is cyclic: shifts below zero are at its far end.
  [[nodiscard]] double cells_of(std::size_t i) const {
    const double v = static_cast<double>(i);
    return i < fft_.side() - reach_ ? v : v - static_cast<double>(fft_.side());
  }

  double cell_m_;
  std::span<const Mark> marks_;
  std::size_t reach_;  ///< of the marks, in cells
  Vec2 low_;
  Fft2 fft_;
  std::size_t mask_;
  double scale_ = 1.0;  ///< from the transform's numbers to a share of the marks
  std::vector<Fft2::Complex> picture_, work_;
};

Correlator::Correlator(const Picture& picture, std::span<const Mark> marks, double cell_m)
    : cell_m_(cell_m),
      marks_(marks),
      reach_(reach_of(marks, cell_m)),
      low_(picture.low_m()),
      fft_(side_for(picture, reach_)),
      mask_(fft_.side() - 1),
      picture_(fft_.side() * fft_.side()),
      work_(fft_.side() * fft_.side()) {
  double all = 0.0;
  for (const Mark& m : marks) all += static_cast<double>(m.weight);
  const double n = static_cast<double>(fft_.side());
  scale_ = 1.0 / (n * n * std::max(all, 1e-9));
  for (std::size_t y = 0; y < static_cast<std::size_t>(picture.ny()); ++y) {
    for (std::size_t x = 0; x < static_cast<std::size_t>(picture.nx()); ++x) {
      picture_[(y & mask_) * fft_.side() + (x & mask_)] +=
          picture.cells()[y * static_cast<std::size_t>(picture.nx()) + x];
    }
  }
  fft_.forward(picture_);
}

/// Puts the turned marks around the corner of the picture, negative places at its far end.
void Correlator::draw(double yaw_rad, bool imaginary) {
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  const int reach = static_cast<int>(reach_);
  for (const Mark& m : marks_) {
    const double mx = static_cast<double>(m.x_m);
    const double my = static_cast<double>(m.y_m);
    const int x = static_cast<int>(std::lround((c * mx - s * my) / cell_m_));
    const int y = static_cast<int>(std::lround((s * mx + c * my) / cell_m_));
    if (std::abs(x) > reach || std::abs(y) > reach) continue;
    Fft2::Complex& cell = work_[(static_cast<std::size_t>(y) & mask_) * fft_.side() +
                                (static_cast<std::size_t>(x) & mask_)];
    cell += imaginary ? Fft2::Complex(0.0F, m.weight) : Fft2::Complex(m.weight, 0.0F);
  }
}

void Correlator::peaks(double yaw_rad, bool imaginary, std::vector<Place>& out) const {
  std::vector<Place> found;
  const std::size_t n = fft_.side();
  float best = 0.0F;
  for (std::size_t i = 0; i < work_.size(); ++i) {
    best = std::max(best, imaginary ? work_[i].imag() : work_[i].real());
  }
  for (std::size_t y = 0; y < n; ++y) {
    for (std::size_t x = 0; x < n; ++x) {
      const float v = value(x, y, imaginary);
      if (v < 0.3F * best) continue;
      bool peak = true;
      for (std::size_t k = 0; k < 9 && peak; ++k) {
        if (k != 4) peak = value(x + k % 3 + n - 1, y + k / 3 + n - 1, imaginary) <= v;
      }
      if (!peak) continue;
      found.push_back({yaw_rad, low_ + cell_m_ * Vec2(cells_of(x) + 0.5, cells_of(y) + 0.5),
                       static_cast<double>(v) * scale_});
    }
  }
  const std::size_t keep = std::min(kPerYaw, found.size());
  std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(keep), found.end(),
                    [](const Place& a, const Place& b) {
                      if (a.correlation != b.correlation) return a.correlation > b.correlation;
                      return std::make_pair(a.shift_m.x(), a.shift_m.y()) <
                             std::make_pair(b.shift_m.x(), b.shift_m.y());
                    });
  out.insert(out.end(), found.begin(), found.begin() + static_cast<std::ptrdiff_t>(keep));
}

void Correlator::correlate(double yaw1_rad, double yaw2_rad, std::vector<Place>& out) {
  std::fill(work_.begin(), work_.end(), Fft2::Complex{});
  draw(yaw1_rad, false);
  draw(yaw2_rad, true);
  fft_.forward(work_);
  // Correlation of A with B1 + i B2 needs conj(F1) + i conj(F2): that of the mirrored picture,
  // whose transform at k is that of the picture at -k.
  const std::size_t n = fft_.side();
  std::vector<Fft2::Complex> product(work_.size());
  for (std::size_t y = 0; y < n; ++y) {
    for (std::size_t x = 0; x < n; ++x) {
      const Fft2::Complex f = picture_[y * n + x];
      const Fft2::Complex g = work_[((n - y) & mask_) * n + ((n - x) & mask_)];
      product[y * n + x] = {f.real() * g.real() - f.imag() * g.imag(),
                            f.real() * g.imag() + f.imag() * g.real()};
    }
  }
  work_.swap(product);
  fft_.back(work_);
  peaks(yaw1_rad, false, out);
  peaks(yaw2_rad, true, out);
}

bool stronger(const Place& a, const Place& b) {
  if (a.correlation != b.correlation) return a.correlation > b.correlation;
  if (a.yaw_rad != b.yaw_rad) return a.yaw_rad < b.yaw_rad;
  if (a.shift_m.x() != b.shift_m.x()) return a.shift_m.x() < b.shift_m.x();
  return a.shift_m.y() < b.shift_m.y();
}

/// Climbs on the finer picture.
void refine(const Picture& picture, std::span<const Mark> marks, double cell_m, double yaw_step,
            Place& place) {
  place.correlation = correlation(picture, marks, place.yaw_rad, place.shift_m);
  double turn = 0.5 * yaw_step;
  double way = 2.0 * cell_m;
  for (int round = 0; round < 3; ++round, turn *= 0.5, way *= 0.5) {
    for (int tries = 0; tries < 4; ++tries) {
      const Place from = place;
      for (int k = 0; k < 6; ++k) {
        Place next = from;
        const double sign = k % 2 == 0 ? 1.0 : -1.0;
        if (k < 2) next.yaw_rad += sign * turn;
        if (k >= 2 && k < 4) next.shift_m.x() += sign * way;
        if (k >= 4) next.shift_m.y() += sign * way;
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
  if (out.size() % 2 == 1) out.push_back(out.front());
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
    if (!kept.empty() && p.correlation < s_.least_share * kept.front().correlation) break;
    if (is_new(p, kept)) kept.push_back(p);
  }
  return kept;
}

/// Horizontal direction along which the target's walls say least.
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
      // What is lost by less overlap alone is not held against it: only the next steps must hold.
      if (k * s_.ridge_step_m <= 3.0 && p.correlation < s_.ridge_share * best.correlation) break;
      if (p.correlation < 0.5 * s_.ridge_share * best.correlation) break;
      (sign > 0 ? ridge.to_m : ridge.from_m) = sign * k * s_.ridge_step_m;
      if (allowed(p, 0.0)) along.push_back(p);
    }
  }
  if (ridge.to_m - ridge.from_m < 4.0) return;  // a room's wall also gives way for a metre or two
  out.ridges.push_back(ridge);
  for (const Place& p : along) out.places.push_back({pose(p), p.correlation, true});
}

Hypotheses Search::run() {
  Hypotheses out;
  if (marks_.empty() || fine_.cells().empty()) return out;
  std::vector<Place> found;
  Correlator correlator(coarse_, coarse_marks_, coarse_m_);
  const std::vector<double> turns = yaws();
  for (std::size_t k = 0; k + 1 < turns.size(); k += 2) {
    correlator.correlate(turns[k], turns[k + 1], found);
  }
  std::erase_if(found, [&](const Place& p) { return !allowed(p, 0.5); });
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
