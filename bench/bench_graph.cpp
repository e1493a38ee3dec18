// Cost of the local pose graph: a drive in a tunnel with one keyframe per second and ranges to a
// vehicle that stands. Arguments: keyframes in the window, ranges in the window.
#include <benchmark/benchmark.h>

#include "rali/base/rng.hpp"
#include "rali/graph/local_graph.hpp"

namespace rali::graph {
namespace {

using geometry::Vec3;

InertialFactor even_second(Seq i, Rng& rng) {
  InertialFactor f;
  f.i = i;
  f.j = i + 1;
  f.duration_s = 1.0;
  f.dv_mps = {0.01 * rng.normal(), 0.01 * rng.normal(), 9.81};
  f.dp_m = {0.006 * rng.normal(), 0.006 * rng.normal(), 4.905};
  f.d_rotation_d_gyro = -geometry::Mat3::Identity();
  f.d_velocity_d_accel = -geometry::Mat3::Identity();
  f.d_position_d_accel = -0.5 * geometry::Mat3::Identity();
  f.covariance.setZero();
  f.covariance.diagonal() << Vec3::Constant(1e-6), Vec3::Constant(1e-4), Vec3::Constant(4e-5);
  return f;
}

void add_second(LocalGraph& graph, Seq k, int ranges, Rng& rng) {
  KeyframeState x;
  x.T_odom_body.p = {k + 0.2 * rng.normal(), 0.02 * rng.normal(), 0.02 * rng.normal()};
  x.v_odom_mps = {1.0, 0.0, 0.0};
  graph.add_keyframe(k, Time::from_s(k), x);
  if (k == 0) {
    PriorFactor prior;
    prior.mean = x;
    prior.information.diagonal().setConstant(1e4);
    graph.add(prior);
    return;
  }
  graph.add(even_second(k - 1, rng));
  RelativePoseFactor lidar;
  lidar.i = k - 1;
  lidar.j = k;
  lidar.T_i_j.p = {1.0, 0.005 * rng.normal(), 0.005 * rng.normal()};
  lidar.information.diagonal() << 8e6, 8e6, 8e6, 0.0, 4e4, 4e4;
  graph.add(lidar);
  for (int n = 0; n < ranges; ++n) {
    RangeFactor f;
    f.id = 1000ULL * k + static_cast<unsigned>(n);
    f.i = k - 1;
    f.j = k;
    f.alpha = (n + 0.5) / ranges;
    f.t = Time::from_s(k - 1 + f.alpha);
    f.p_i_m = {f.alpha, 0.0, 0.3};
    f.p_j_m = {f.alpha - 1.0, 0.0, 0.3};
    f.landmark = 0;
    f.bias = 0;
    f.tau = 0;
    const Vec3 p(k - 1 + f.alpha, 0.0, 0.3);
    f.range_m = (p - Vec3(-10.0, 1.0, 0.5)).norm() + 0.1 * rng.normal();
    graph.add(f);
  }
}

LocalGraph drive(int keyframes, int ranges) {
  LocalGraph graph{LocalGraphSettings{}};
  Rng rng(1, "bench");
  graph.add_landmark(0, {-10.0, 1.0, 0.5}, geometry::Mat3::Identity() * 1e-4);
  graph.add_bias(0, 0.0, 0.1);
  graph.add_tau(0, 0.0, 0.02);
  for (int k = 0; k < keyframes; ++k) {
    add_second(graph, static_cast<Seq>(k), ranges / keyframes, rng);
  }
  return graph;
}

// From a start that is 0.2 m off, to convergence.
void solve_window(benchmark::State& state) {
  const auto keyframes = static_cast<int>(state.range(0));
  int iterations = 0;
  for (auto _ : state) {
    state.PauseTiming();
    LocalGraph graph = drive(keyframes, static_cast<int>(state.range(1)));
    state.ResumeTiming();
    iterations = graph.solve(20).iterations;
  }
  state.counters["iterations"] = iterations;
}

// What a vehicle does at each keyframe: solve, ask for covariances, marginalise.
void one_keyframe(benchmark::State& state) {
  const auto keyframes = static_cast<int>(state.range(0));
  const int ranges = static_cast<int>(state.range(1)) / keyframes;
  LocalGraph graph = drive(keyframes, static_cast<int>(state.range(1)));
  graph.solve(20);
  Rng rng(2, "bench");
  Seq k = static_cast<Seq>(keyframes);
  for (auto _ : state) {
    add_second(graph, k++, ranges, rng);
    graph.solve(graph.settings().iterations);
    benchmark::DoNotOptimize(graph.newest_covariance());
    graph.marginalise_oldest();
  }
}

void worst_range(benchmark::State& state) {
  LocalGraph graph = drive(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  graph.solve(20);
  for (auto _ : state) benchmark::DoNotOptimize(graph.largest_nis_range());
}

BENCHMARK(solve_window)
    ->Args({20, 150})
    ->Args({40, 300})
    ->Args({60, 1200})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(one_keyframe)
    ->Args({20, 150})
    ->Args({40, 300})
    ->Args({60, 1200})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(worst_range)->Args({40, 300})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rali::graph

BENCHMARK_MAIN();
