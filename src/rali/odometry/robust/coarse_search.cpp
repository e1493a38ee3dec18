#include "rali/odometry/robust/coarse_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Geometry>

#include "rali/odometry/robust/scan_sampler.hpp"
#include "rali/odometry/robust/wide_search.hpp"

namespace rali::odometry {

using geometry::SE3;
using geometry::Vec3;
using geometry::Vec3f;

namespace {

constexpr std::size_t kPointsMin = 50;

/// Proximity of the recent points: a dense cube of cells around the guess, each with a value that
/// falls from 255 at a point to 0 about one and a half cells away.
class Nearness {
 public:
  Nearness(const Vec3& center_odom_m, double cell_m)
      : origin_(center_odom_m.cast<float>() - Vec3f::Constant(static_cast<float>(kHalf * cell_m))),
        inverse_(static_cast<float>(1.0 / cell_m)),
        cells_(static_cast<std::size_t>(kEdge) * kEdge * kEdge, 0) {}

  void mark(const Vec3f& p) {
    const Vec3f q = (p - origin_) * inverse_;
    if (!((q.array() >= 1.0F).all() && (q.array() < kEdge - 1.0F).all())) return;
    const int x = static_cast<int>(q.x());
    const int y = static_cast<int>(q.y());
    const int z = static_cast<int>(q.z());
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const Vec3f center(static_cast<float>(x + dx) + 0.5F, static_cast<float>(y + dy) + 0.5F,
                             static_cast<float>(z + dz) + 0.5F);
          const float near = 1.0F - (q - center).squaredNorm() * (1.0F / (kReach * kReach));
          if (near <= 0.0F) continue;
          std::uint8_t& cell = cells_[index(x + dx, y + dy, z + dz)];
          cell = std::max(cell, static_cast<std::uint8_t>(255.0F * near));
        }
      }
    }
  }

  [[nodiscard]] int at(const Vec3f& p) const {
    const Vec3f q = (p - origin_) * inverse_;
    if (!((q.array() >= 0.0F).all() && (q.array() < float{kEdge}).all())) return 0;
    return cells_[index(static_cast<int>(q.x()), static_cast<int>(q.y()), static_cast<int>(q.z()))];
  }

 private:
  static constexpr int kEdge = 128;
  static constexpr double kHalf = 0.5 * kEdge;
  static constexpr float kReach = 1.6F;  ///< cells

  static std::size_t index(int x, int y, int z) {
    return (static_cast<std::size_t>(z) * kEdge + static_cast<std::size_t>(y)) * kEdge +
           static_cast<std::size_t>(x);
  }

  Vec3f origin_;
  float inverse_;
  std::vector<std::uint8_t> cells_;
};

struct Trial {
  SE3 T;
  double value = -1e9;
  int heading = 0;
};

class Search {
 public:
  Search(const Nearness& nearness, const std::vector<Vec3f>& points, const PoseGuess& prior)
      : nearness_(nearness), points_(points), prior_(prior) {}

  /// Mean nearness of the points minus the penalty for the distance from the prior.
  [[nodiscard]] double value(const SE3& T) const {
    // 0.01 per sigma^2: a quarter of the points outweighs 5 sigma.
    constexpr double kPriorWeight = 0.01;
    const double turn =
        geometry::so3_log(prior_.T_odom_body.R.transpose() * T.R).norm() / prior_.sigma_rad;
    const double shift = (T.p - prior_.T_odom_body.p).norm() / prior_.sigma_m;
    const Eigen::Matrix3f R = T.R.cast<float>();
    const Vec3f p = T.p.cast<float>();
    int sum = 0;
    for (const Vec3f& x : points_) sum += nearness_.at(R * x + p);
    return sum / (255.0 * static_cast<double>(points_.size())) -
           kPriorWeight * (turn * turn + shift * shift);
  }

  /// The best trial of each heading, best first.
  [[nodiscard]] std::vector<Trial> try_grid(const Vec3& up, double step_m, int n_m, double step_rad,
                                            int n_rad) const {
    std::vector<Trial> best(static_cast<std::size_t>(2 * n_rad + 1));
    for_each(up, step_m, n_m, step_rad, n_rad, [&](const Trial& trial) {
      Trial& here = best[static_cast<std::size_t>(trial.heading + n_rad)];
      if (trial.value > here.value) here = trial;
    });
    return sorted(std::move(best));
  }

  /// All trials, best first.
  [[nodiscard]] std::vector<Trial> try_all(const Vec3& up, double step_m, int n_m, double step_rad,
                                           int n_rad) const {
    std::vector<Trial> all;
    for_each(up, step_m, n_m, step_rad, n_rad, [&](const Trial& trial) { all.push_back(trial); });
    return sorted(std::move(all));
  }

  /// Hill climbing along each of the six directions in turn with shrinking steps.
  void climb(Trial& t, double step_m, double step_rad) const {
    constexpr int kHalvings = 3;
    constexpr int kRounds = 4;
    for (int h = 0; h < kHalvings; ++h, step_m *= 0.5, step_rad *= 0.5) {
      bool better = true;
      for (int round = 0; better && round < kRounds; ++round) {
        better = false;
        for (int k = 0; k < 12; ++k) {
          Vec3 d = Vec3::Zero();
          d[k / 4] = (k & 1) != 0 ? 1.0 : -1.0;
          SE3 trial = t.T;
          if ((k & 2) != 0) {
            trial.R = geometry::so3_exp(step_rad * d) * t.T.R;
          } else {
            trial.p += step_m * d;
          }
          const double v = value(trial);
          if (v <= t.value) continue;
          t.T = trial;
          t.value = v;
          better = true;
        }
      }
    }
  }

 private:
  template <class Use>
  void for_each(const Vec3& up, double step_m, int n_m, double step_rad, int n_rad,
                const Use& use) const {
    const Vec3 helper = std::abs(up.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
    const Vec3 h1 = (helper - helper.dot(up) * up).normalized();
    const Vec3 h2 = up.cross(h1);
    const SE3& center = prior_.T_odom_body;
    for (int a = -n_rad; a <= n_rad; ++a) {
      Trial trial;
      trial.heading = a;
      trial.T.R = geometry::so3_exp(a * step_rad * up) * center.R;
      for (int i = -n_m; i <= n_m; ++i) {
        for (int j = -n_m; j <= n_m; ++j) {
          trial.T.p = center.p + step_m * (i * h1 + j * h2);
          trial.value = value(trial.T);
          use(trial);
        }
      }
    }
  }

  static std::vector<Trial> sorted(std::vector<Trial> trials) {
    std::stable_sort(trials.begin(), trials.end(),
                     [](const Trial& x, const Trial& y) { return x.value > y.value; });
    return trials;
  }

  const Nearness& nearness_;
  const std::vector<Vec3f>& points_;
  const PoseGuess& prior_;
};

std::vector<Vec3f> some_points(const BodyPoints& body, int n) {
  std::vector<std::uint32_t> indices(body.size());
  for (std::uint32_t i = 0; i < indices.size(); ++i) indices[i] = i;
  thin_evenly(indices, static_cast<std::size_t>(n));
  std::vector<Vec3f> points;
  points.reserve(indices.size());
  for (const std::uint32_t i : indices) {
    const Vec3f p(body.x_m[i], body.y_m[i], body.z_m[i]);
    if (p.allFinite()) points.push_back(p);
  }
  return points;
}

double median_range(const std::vector<Vec3f>& points) {
  std::vector<float> ranges;
  ranges.reserve(points.size());
  for (const Vec3f& p : points) ranges.push_back(p.norm());
  const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::nth_element(ranges.begin(), middle, ranges.end());
  return static_cast<double>(*middle);
}

}  // namespace

void RecentPoints::add(const BodyPoints& points, const SE3& T_odom_body) {
  constexpr std::size_t kScansMax = 10;
  if (scans_.size() == kScansMax) {
    std::vector<Vec3f> oldest = std::move(scans_.front());  // reuses its memory
    scans_.pop_front();
    scans_.push_back(std::move(oldest));
    scans_.back().clear();
    poses_.pop_front();
  } else {
    scans_.emplace_back();
  }
  poses_.push_back(T_odom_body);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 p = geometry::Vec3f(points.x_m[i], points.y_m[i], points.z_m[i]).cast<double>();
    scans_.back().push_back((T_odom_body * p).cast<float>());
  }
}

PoseGuess guess_from(const SE3& T_odom_body, const geometry::Mat6& P, std::span<const Vec3> unseen,
                     const Vec3& up_odom) {
  geometry::Mat6 rest = P;  // conditioned on the position along the unseen axes
  for (const Vec3& axis : unseen) {
    const geometry::Vec6 along = rest.rightCols<3>() * axis;
    const double variance_m2 = axis.dot(along.tail<3>());
    if (variance_m2 > 0.0) rest -= (along * along.transpose() / variance_m2).eval();
  }
  const Vec3 up_body = T_odom_body.R.transpose() * up_odom;
  const double variance_m2 = rest.block<2, 2>(3, 3).diagonal().maxCoeff();
  const double variance_rad2 = up_body.dot(rest.topLeftCorner<3, 3>() * up_body);
  return {T_odom_body, std::sqrt(std::max(0.0, variance_m2)),
          std::sqrt(std::max(0.0, variance_rad2))};
}

bool needs_search(const PoseGuess& guess, const CoarseSearchSettings& settings) {
  constexpr double kRadian = std::numbers::pi / 180.0;
  return guess.sigma_m >= settings.sigma_min_m ||
         guess.sigma_rad >= settings.sigma_min_deg * kRadian;
}

std::vector<SE3> search_pose(const RecentPoints& recent, const BodyPoints& body,
                             const PoseGuess& guess, const Vec3& up_odom,
                             const CoarseSearchSettings& settings) {
  constexpr std::size_t kCandidates = 3;
  return search_headings(recent, body, guess, up_odom, settings, kCandidates);
}

namespace {

/// The steps of a grid around a guess.
struct Grid {
  double cell_m, step_rad;
  int n_m, n_rad;
};

/// @param range_m median range of the scan
Grid grid_of(const PoseGuess& guess, double range_m, double cell_m,
             const CoarseSearchSettings& settings) {
  constexpr double kRadian = std::numbers::pi / 180.0;
  constexpr double kSigmas = 4.0;
  const double step_rad = 1.25 * cell_m / std::max(range_m, cell_m / 0.2);
  const double reach_m = std::min(settings.range_max_m, kSigmas * guess.sigma_m);
  const double reach_rad = std::min(settings.range_max_deg * kRadian, kSigmas * guess.sigma_rad);
  return {cell_m, step_rad, static_cast<int>(std::ceil(reach_m / cell_m)),
          static_cast<int>(std::ceil(reach_rad / step_rad))};
}

/// A cell of 2.3 degrees as seen from the sensor.
double usual_cell_m(double range_m) {
  constexpr double kCellPerRange = 0.04;
  constexpr double kCellMin_m = 0.15;
  constexpr double kCellMax_m = 1.0;
  return std::clamp(kCellPerRange * range_m, kCellMin_m, kCellMax_m);
}

Nearness nearness_of(const RecentPoints& recent, const PoseGuess& guess, double cell_m) {
  Nearness nearness(guess.T_odom_body.p, cell_m);
  for (const auto& scan : recent.scans()) {
    for (const Vec3f& p : scan) nearness.mark(p);
  }
  return nearness;
}

/// Refines the trials; those that climb to the same maximum are one.
std::vector<SE3> climbed(const Search& search, const Grid& grid, std::vector<Trial> trials) {
  for (Trial& t : trials) search.climb(t, 0.5 * grid.cell_m, 0.5 * grid.step_rad);
  std::stable_sort(trials.begin(), trials.end(),
                   [](const Trial& x, const Trial& y) { return x.value > y.value; });
  std::vector<SE3> out;
  for (const Trial& t : trials) {
    const bool known = std::any_of(out.begin(), out.end(), [&](const SE3& other) {
      return (other.p - t.T.p).norm() < 0.5 * grid.cell_m &&
             geometry::so3_log(other.R.transpose() * t.T.R).norm() < 0.5 * grid.step_rad;
    });
    if (!known) out.push_back(t.T);
  }
  return out;
}

}  // namespace

std::vector<SE3> search_headings(const RecentPoints& recent, const BodyPoints& body,
                                 const PoseGuess& guess, const Vec3& up_odom,
                                 const CoarseSearchSettings& settings, std::size_t candidates) {
  const std::vector<Vec3f> points = some_points(body, settings.points);
  if (points.size() < kPointsMin) return {};
  const double range_m = std::max(0.1, median_range(points));
  constexpr double kCells = 40.0;
  const double cell_m = std::max(usual_cell_m(range_m), settings.range_max_m / kCells);
  const Nearness nearness = nearness_of(recent, guess, cell_m);
  const Search search(nearness, points, guess);
  const Grid grid = grid_of(guess, range_m, cell_m, settings);
  constexpr int kApart = 2;  // nearer headings climb to the same maximum
  std::vector<Trial> best;
  for (const Trial& t :
       search.try_grid(up_odom, grid.cell_m, grid.n_m, grid.step_rad, grid.n_rad)) {
    const bool known = std::any_of(best.begin(), best.end(), [&t](const Trial& other) {
      return std::abs(other.heading - t.heading) <= kApart;
    });
    if (!known) best.push_back(t);
    if (best.size() == candidates) break;
  }
  return climbed(search, grid, std::move(best));
}

std::vector<SE3> search_places(const RecentPoints& recent, const BodyPoints& body,
                               const PoseGuess& guess, const Vec3& up_odom,
                               const CoarseSearchSettings& settings, double apart_m,
                               std::size_t candidates) {
  constexpr double kCells = 24.0;  // from the middle of the grid to its border
  const std::vector<Vec3f> points = some_points(body, settings.points);
  if (points.size() < kPointsMin) return {};
  const double range_m = std::max(0.1, median_range(points));
  const double cell_m = std::max(usual_cell_m(range_m), settings.range_max_m / kCells);
  const Nearness nearness = nearness_of(recent, guess, cell_m);
  const Search search(nearness, points, guess);
  const Grid grid = grid_of(guess, range_m, cell_m, settings);
  constexpr int kApart = 3;
  std::vector<Trial> best;
  for (const Trial& t : search.try_all(up_odom, grid.cell_m, grid.n_m, grid.step_rad, grid.n_rad)) {
    const bool known = std::any_of(best.begin(), best.end(), [&](const Trial& other) {
      return std::abs(other.heading - t.heading) <= kApart && (other.T.p - t.T.p).norm() <= apart_m;
    });
    if (!known) best.push_back(t);
    if (best.size() == candidates) break;
  }
  return climbed(search, grid, std::move(best));
}

}  // namespace rali::odometry
