#include "rali/odometry/robust/coarse_search.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "rali/odometry/robust/scan_sampler.hpp"

namespace rali::odometry {

using geometry::SE3;
using geometry::Vec3;

namespace {

struct Grid {
  double step_m, step_rad;
  int n_m, n_rad;       ///< steps to each side
  double tolerance_m;   ///< a point farther from its plane scores nothing
};

/// Points near a plane of the map, each counting by how near, as a share of all points.
double score(const PlaneMap& map, const std::vector<Vec3>& points, const SE3& T,
             double tolerance_m) {
  double sum = 0.0;
  const double inverse2 = 1.0 / (tolerance_m * tolerance_m);
  for (const Vec3& p : points) {
    const Vec3 x = T * p;
    const int index = map.find(x);
    if (index < 0) continue;
    const Plane& plane = map.plane(index);
    const double r = plane.n.dot(x - plane.q);
    sum += std::max(0.0, 1.0 - r * r * inverse2);
  }
  return sum / static_cast<double>(points.size());
}

struct Trial {
  SE3 T;
  double value = -1e9;
};

/// The best trial of each heading, best first.
std::vector<Trial> try_grid(const PlaneMap& map, const std::vector<Vec3>& points,
                            const SE3& center, const PoseGuess& prior, const Vec3& up,
                            const Grid& grid) {
  // 0.01 per sigma^2: a quarter of the points outweighs 5 sigma.
  constexpr double kPriorWeight = 0.01;
  const Vec3 helper = std::abs(up.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 h1 = (helper - helper.dot(up) * up).normalized();
  const Vec3 h2 = up.cross(h1);
  std::vector<Trial> best;
  for (int a = -grid.n_rad; a <= grid.n_rad; ++a) {
    SE3 trial = center;
    trial.R = geometry::so3_exp(a * grid.step_rad * up) * center.R;
    const double turn =
        geometry::so3_log(prior.T_odom_body.R.transpose() * trial.R).norm() / prior.sigma_rad;
    Trial& here = best.emplace_back();
    for (int i = -grid.n_m; i <= grid.n_m; ++i) {
      for (int j = -grid.n_m; j <= grid.n_m; ++j) {
        trial.p = center.p + grid.step_m * (i * h1 + j * h2);
        const double shift = (trial.p - prior.T_odom_body.p).norm() / prior.sigma_m;
        const double value = score(map, points, trial, grid.tolerance_m) -
                             kPriorWeight * (turn * turn + shift * shift);
        if (value > here.value) here = {trial, value};
      }
    }
  }
  std::stable_sort(best.begin(), best.end(),
                   [](const Trial& x, const Trial& y) { return x.value > y.value; });
  return best;
}

}  // namespace

SE3 search_pose(const PlaneMap& map, const BodyPoints& body, const PoseGuess& guess,
                const Vec3& up_odom, const CoarseSearchSettings& settings) {
  constexpr double kRadian = std::numbers::pi / 180.0;
  constexpr double kSigmas = 4.0;
  const bool good = guess.sigma_m < settings.sigma_min_m &&
                    guess.sigma_rad < settings.sigma_min_deg * kRadian;
  if (good || body.size() < 50 || map.plane_count() < 10) return guess.T_odom_body;
  std::vector<std::uint32_t> indices(body.size());
  for (std::uint32_t i = 0; i < indices.size(); ++i) indices[i] = i;
  thin_evenly(indices, static_cast<std::size_t>(settings.points));
  std::vector<Vec3> points;
  for (const std::uint32_t i : indices) points.emplace_back(body.x_m[i], body.y_m[i], body.z_m[i]);

  Grid coarse{0.2, 3.0 * kRadian, 0, 0, 0.2};
  const double range_m = std::min(settings.range_max_m, kSigmas * guess.sigma_m);
  const double range_rad = std::min(settings.range_max_deg * kRadian, kSigmas * guess.sigma_rad);
  coarse.n_m = static_cast<int>(std::ceil(range_m / coarse.step_m));
  coarse.n_rad = static_cast<int>(std::ceil(range_rad / coarse.step_rad));
  const std::vector<Trial> near =
      try_grid(map, points, guess.T_odom_body, guess, up_odom, coarse);
  const Grid fine{0.07, 1.0 * kRadian, 2, 2, 0.1};
  constexpr std::size_t kCandidates = 4;
  Trial best;
  for (std::size_t k = 0; k < std::min(kCandidates, near.size()); ++k) {
    const Trial t = try_grid(map, points, near[k].T, guess, up_odom, fine).front();
    if (t.value > best.value) best = t;
  }
  return best.T;
}

}  // namespace rali::odometry
