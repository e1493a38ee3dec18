#include "slam_placing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "rali/geometry/so3.hpp"

namespace rali::ranges_bench {

using geometry::SE3;
using geometry::Vec3;

namespace {

ranging::FinderSettings settings_of(const SlamProblem& problem) {
  ranging::FinderSettings s;
  // A drone is not at the height of a beacon on the ground.
  s.height_sigma_m = problem.planar ? 0.01 : 3.0;
  // The default settings are for radios with decimetre accuracy, in buildings.
  const double scale = std::max(1.0, problem.ranges.front().sigma_m / 0.1);
  s.sigma_max_m *= scale;
  s.merge_m *= scale;
  s.travel_again_m *= scale;
  return s;
}

double bias_sigma_of(const SlamProblem& problem) {
  return problem.bias_sigma_m > 0.0 ? problem.bias_sigma_m : 0.01;
}

ranging::FinderSample sample_of(const TrackRange& range, const Vec3& p_odom_m, double variance_m2) {
  ranging::FinderSample s;
  s.t = range.t;
  s.p_odom_antenna_m = p_odom_m;
  s.covariance_m2 = variance_m2 * geometry::Mat3::Identity();
  s.range_m = range.range_m;
  s.sigma_m = range.sigma_m;
  return s;
}

/// The finder's best minimum over the first ranges, accepted or not.
PlacedBeacon best_guess(const SlamProblem& problem, const eval::PoseList& odometry, int beacon,
                        const std::vector<double>& variances) {
  ranging::FinderSettings s = settings_of(problem);
  s.spacing_m = s.travel_min_m = s.travel_again_m = 0.0;
  s.rival_chi2 = 0.0;
  s.samples_min = 5;
  s.samples_max = 60;
  s.chi2_max = s.sigma_max_m = 1e9;
  ranging::AnchorFinder finder(s, 0.0, bias_sigma_of(problem));
  PlacedBeacon out;
  std::optional<TrackRange> first;
  int asked = 0;
  for (std::size_t k = 0; k < problem.ranges.size() && asked < s.samples_max; ++k) {
    const TrackRange& range = problem.ranges[k];
    if (range.beacon != beacon) continue;
    ++asked;
    const Vec3& p = odometry[range.pose].T.p;
    if (!first) {
      first = range;
      out.p_odom_m = p + Vec3(range.range_m, 0.0, 0.0);
    }
    const auto found = finder.add(sample_of(range, p, variances[range.pose]), 0.0, Vec3::UnitZ());
    if (!found) continue;
    out.p_odom_m = found->p_odom_m;
    out.covariance_m2 = found->covariance_m2;
    out.after_range = k;
  }
  return out;
}

/// x, y, yaw of odom in world.
SE3 level_frame(const Vec3& x) {
  return {geometry::rotation_from_rpy(0.0, 0.0, x[2]), Vec3(x[0], x[1], 0.0)};
}

double frame_cost(std::span<const TrackRange> ranges, const eval::PoseList& odometry, const Vec3& x,
                  geometry::Mat3& H, Vec3& g) {
  const SE3 T = level_frame(x);
  double cost = 0.0;
  H.setZero();
  g.setZero();
  for (const TrackRange& range : ranges) {
    const Vec3 turned = T.R * odometry[range.pose].T.p;
    const Vec3 h = turned + T.p - range.p_known_m;
    const double rho = std::max(1e-3, h.norm());
    // Odometry drifts: a frame accurate to decimetres is sufficient.
    const double r = (rho - range.range_m) / std::max(0.3, range.sigma_m);
    const double weight = std::abs(r) > 2.0 ? 2.0 / std::abs(r) : 1.0;
    const Vec3 d_yaw(-turned.y(), turned.x(), 0.0);
    const Vec3 J = Vec3(h.x(), h.y(), h.dot(d_yaw)) / (rho * std::max(0.3, range.sigma_m));
    H += weight * J * J.transpose();
    g += weight * r * J;
    cost += std::abs(r) > 2.0 ? 4.0 * std::abs(r) - 4.0 : r * r;
  }
  return cost;
}

std::pair<Vec3, double> refine_frame(std::span<const TrackRange> ranges,
                                     const eval::PoseList& odometry, Vec3 x) {
  geometry::Mat3 H;
  Vec3 g;
  double cost = frame_cost(ranges, odometry, x, H, g);
  double lambda = 1e-3;
  for (int k = 0; k < 30 && lambda < 1e6; ++k) {
    geometry::Mat3 damped = H;
    damped.diagonal() *= 1.0 + lambda;
    const Vec3 moved = x - Vec3(damped.ldlt().solve(g));
    geometry::Mat3 H_new;
    Vec3 g_new;
    const double cost_new = frame_cost(ranges, odometry, moved, H_new, g_new);
    if (!(cost_new < cost)) {
      lambda *= 10.0;
      continue;
    }
    const bool done = cost - cost_new < 1e-6 * cost;
    x = moved;
    cost = cost_new;
    H = H_new;
    g = g_new;
    lambda *= 0.1;
    if (done) break;
  }
  return {x, cost};
}

}  // namespace

BeaconFinder::BeaconFinder(const SlamProblem& problem)
    : finder_(settings_of(problem), 0.0, bias_sigma_of(problem)) {}

std::optional<ranging::FoundAnchor> BeaconFinder::add(const TrackRange& range, const Vec3& p_odom_m,
                                                      double variance_m2) {
  return finder_.add(sample_of(range, p_odom_m, variance_m2), 0.0, Vec3::UnitZ());
}

std::vector<double> position_variances(const SlamProblem& problem) {
  std::vector<double> out{0.0};
  for (const graph::RelativePoseFactor& step : problem.steps) {
    const geometry::Mat6 C = step.information.inverse();
    out.push_back(out.back() + 0.5 * (C(3, 3) + C(4, 4)));
  }
  return out;
}

std::map<int, PlacedBeacon> place_beacons(const SlamProblem& problem,
                                          const eval::PoseList& odometry) {
  const std::vector<double> variances = position_variances(problem);
  std::map<int, PlacedBeacon> out;
  std::map<int, BeaconFinder> finders;
  for (std::size_t k = 0; k < problem.ranges.size(); ++k) {
    const TrackRange& range = problem.ranges[k];
    if (!range.beacon || out.contains(*range.beacon)) continue;
    BeaconFinder& finder = finders.try_emplace(*range.beacon, problem).first->second;
    const auto found = finder.add(range, odometry[range.pose].T.p, variances[range.pose]);
    if (!found) continue;
    out.emplace(*range.beacon, PlacedBeacon{found->p_odom_m, found->covariance_m2, k, true});
  }
  for (const auto& [beacon, truth] : problem.beacons_m) {
    if (!out.contains(beacon)) {
      out.emplace(beacon, best_guess(problem, odometry, beacon, variances));
    }
  }
  return out;
}

SE3 place_frame(const SlamProblem& problem, const eval::PoseList& odometry, std::size_t maximum) {
  const auto ranges = std::span(problem.ranges).first(std::min(maximum, problem.ranges.size()));
  constexpr int kHeadings = 12;
  const TrackRange& first = problem.ranges.front();
  Vec3 best = Vec3::Zero();
  double best_cost = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kHeadings * kHeadings; ++k) {
    const double heading = 2.0 * std::numbers::pi * (k % kHeadings) / kHeadings;
    const double around = 2.0 * std::numbers::pi * (k / kHeadings) / kHeadings;
    const Vec3 on_circle =
        first.p_known_m + first.range_m * Vec3(std::cos(around), std::sin(around), 0.0);
    Vec3 x(0.0, 0.0, heading);
    const Vec3 start = on_circle - level_frame(x).R * odometry[first.pose].T.p;
    x.head<2>() = start.head<2>();
    const auto [refined, cost] = refine_frame(ranges, odometry, x);
    if (cost >= best_cost) continue;
    best_cost = cost;
    best = refined;
  }
  return level_frame(best);
}

}  // namespace rali::ranges_bench
