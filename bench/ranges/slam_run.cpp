#include "slam_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Core>

namespace rali::ranges_bench {

using geometry::SE3;
using geometry::Vec3;
using graph::KeyframeState;
using graph::PoseGraph;
using graph::Seq;

namespace {

constexpr double kWide_m = 1000.0;
constexpr int kIterations = 5;  ///< at each pose

/// States not estimated here (velocity, biases) are fixed. The first pose is the gauge, or free in
/// x, y and heading where known points determine them.
graph::PriorFactor prior_of(Seq seq, const KeyframeState& x, const SlamProblem& problem) {
  graph::PriorFactor f;
  f.i = seq;
  f.mean = x;
  f.information.diagonal().tail<9>().setOnes();
  if (seq > 0) return f;
  f.information.diagonal().head<6>().setConstant(1e8);
  if (problem.known_points()) {
    f.information(graph::kTheta + 2, graph::kTheta + 2) = 0.1;
    f.information(graph::kPos, graph::kPos) = 1e-4;
    f.information(graph::kPos + 1, graph::kPos + 1) = 1e-4;
  }
  return f;
}

void add_pose(const SlamProblem& problem, std::size_t k, const SE3& T, PoseGraph& graph) {
  KeyframeState x;
  x.T_odom_body = T;
  const Seq seq = graph.add_state(x);
  graph.add(prior_of(seq, x, problem));
  if (k > 0) graph.add(problem.steps[k - 1]);
}

void add_beacon(const SlamProblem& problem, int number, const Vec3& p_odom_m,
                const geometry::Mat3& covariance_m2, PoseGraph& graph) {
  geometry::Mat3 C = covariance_m2;
  if (problem.planar) {
    C.row(2).setZero();
    C.col(2).setZero();
    C(2, 2) = kPlanarSigma * kPlanarSigma;
  }
  Vec3 p = p_odom_m;
  if (problem.planar) p.z() = 0.0;
  graph.add_landmark(number, p, C);
  if (problem.bias_sigma_m > 0.0) graph.add_bias(number, 0.0, problem.bias_sigma_m);
}

graph::RangeFactor factor_of(const SlamProblem& problem, std::size_t index) {
  const TrackRange& range = problem.ranges[index];
  graph::RangeFactor f;
  f.id = index;
  f.t = range.t;
  f.i = static_cast<Seq>(range.pose);
  f.landmark = range.beacon;
  f.p_fixed_odom_m = range.p_known_m;
  if (problem.bias_sigma_m > 0.0) f.bias = range.beacon;
  f.range_m = range.range_m;
  f.sigma_m = range.sigma_m;
  return f;
}

void read_beacons(const SlamProblem& problem, PoseGraph& graph, SlamEstimate& out) {
  for (const auto& [number, truth] : problem.beacons_m) {
    if (!graph.contains(graph::landmark_id(number))) continue;
    out.beacons_m.emplace(number, graph.landmark(number).p_map_m);
    if (problem.bias_sigma_m > 0.0) out.biases_m.emplace(number, graph.bias(number).mean);
  }
}

void note(double nu_m, double variance_m2, Innovations& out) {
  const double nis = nu_m * nu_m / variance_m2;
  ++out.count;
  out.sum_m += nu_m;
  out.square_m2 += nu_m * nu_m;
  out.nis += nis;
  out.beyond += nis > 10.83 ? 1 : 0;
}

}  // namespace

SlamEstimate solve_batch(const SlamProblem& problem, const eval::PoseList& initial,
                         const std::map<int, Vec3>& placed) {
  graph::GraphSettings settings;
  settings.cost_change_min = 1e-6;  // a long trajectory converges slowly
  settings.step_min_m = 1e-5;
  PoseGraph graph(settings);
  for (std::size_t k = 0; k < initial.size(); ++k) add_pose(problem, k, initial[k].T, graph);
  for (const auto& [number, p] : placed) {
    add_beacon(problem, number, p, kWide_m * kWide_m * geometry::Mat3::Identity(), graph);
  }
  for (std::size_t k = 0; k < problem.ranges.size(); ++k) graph.add(factor_of(problem, k));
  SlamEstimate out;
  const graph::SolveReport report = graph.solve(100);
  out.iterations = report.iterations;
  out.cost = report.cost_after;
  for (std::size_t k = 0; k < initial.size(); ++k) {
    out.poses.push_back({problem.truth[k].t, graph.pose(static_cast<Seq>(k))});
  }
  read_beacons(problem, graph, out);
  return out;
}

/// All ranges cover the whole path, but with odometry drift; the first few have neither.
static SlamEstimate solve_in_world(const SlamProblem& problem, const eval::PoseList& odometry) {
  SlamEstimate best;
  best.cost = std::numeric_limits<double>::infinity();
  for (const std::size_t maximum : {problem.ranges.size(), problem.ranges.size() / 3, kFewRanges}) {
    const SE3 T = place_frame(problem, odometry, maximum);
    eval::PoseList initial = odometry;
    for (eval::StampedPose& pose : initial) pose.T = T * pose.T;
    SlamEstimate other = solve_batch(problem, initial, {});
    if (other.cost < best.cost) best = std::move(other);
  }
  return best;
}

SlamEstimate solve_batch_from(const SlamProblem& problem, const eval::PoseList& initial,
                              const std::map<int, PlacedBeacon>& placed) {
  constexpr int kDirections = 8;
  if (problem.known_points()) return solve_in_world(problem, initial);
  std::map<int, Vec3> places;
  for (const auto& [number, beacon] : placed) places.emplace(number, beacon.p_odom_m);
  SlamEstimate best = solve_batch(problem, initial, places);
  for (const auto& [number, beacon] : placed) {
    if (beacon.certain || placed.size() > 1) continue;
    const int wanted = number;
    const auto first =
        std::find_if(problem.ranges.begin(), problem.ranges.end(),
                     [wanted](const TrackRange& range) { return range.beacon == wanted; });
    for (int k = 0; k < kDirections; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kDirections;
      const Vec3 path = first->range_m * Vec3(std::cos(angle), std::sin(angle), 0.0);
      places[number] = initial[first->pose].T.p + path;
      SlamEstimate other = solve_batch(problem, initial, places);
      if (other.cost < best.cost) best = std::move(other);
    }
    places[number] = best.beacons_m.at(number);
  }
  return best;
}

SlamEstimate solve_window(const SlamProblem& problem, const SE3& first, std::size_t window) {
  PoseGraph graph{graph::GraphSettings{}};
  SlamEstimate out;
  std::map<int, BeaconFinder> finders;
  const std::vector<double> variances = position_variances(problem);
  std::size_t next = 0;
  for (std::size_t k = 0; k < problem.truth.size(); ++k) {
    const SE3 T = k == 0 ? first : out.poses.back().T * problem.steps[k - 1].T_i_j;
    add_pose(problem, k, T, graph);
    bool ranged = false;
    for (; next < problem.ranges.size() && problem.ranges[next].pose == k; ++next) {
      const TrackRange& range = problem.ranges[next];
      if (range.beacon && !graph.contains(graph::landmark_id(*range.beacon))) {
        BeaconFinder& finder = finders.try_emplace(*range.beacon, problem).first->second;
        const auto found = finder.add(range, T.p, variances[k]);
        if (found) add_beacon(problem, *range.beacon, found->p_odom_m, found->covariance_m2, graph);
        continue;
      }
      const graph::RangeFactor f = factor_of(problem, next);
      const graph::RangePrediction expected = graph.predict(f);
      note(f.range_m - expected.range_m, expected.variance_m2 + f.sigma_m * f.sigma_m,
           out.innovations);
      graph.add(f);
      ranged = true;
    }
    if (ranged) graph.solve(kIterations);
    out.poses.push_back({problem.truth[k].t, graph.state(static_cast<Seq>(k)).T_odom_body});
    while (graph.nodes().size() > window) graph.marginalise({graph.nodes().front().seq});
  }
  read_beacons(problem, graph, out);
  return out;
}

}  // namespace rali::ranges_bench
