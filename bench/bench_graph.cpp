// Cost of the pose graph. Vehicles follow each other with one node and one range to each of the
// others per second. Every fourth interval of 20 nodes is degenerate and inertial. Arguments:
// vehicles, nodes of each.
#include <numeric>

#include <Eigen/SparseCholesky>
#include <benchmark/benchmark.h>

#include "rali/base/rng.hpp"
#include "rali/graph/block_cholesky.hpp"
#include "rali/graph/pose_graph.hpp"

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

constexpr int kStretch = 20;
constexpr int kDegenerateEach = 4;

bool is_degenerate(int k) { return (k / kStretch) % kDegenerateEach == kDegenerateEach - 1; }

// One vehicle's nodes: poses, and states where the next or previous step is degenerate.
void add_path(PoseGraph& graph, int vehicle, int nodes, Rng& rng) {
  const double y = 3.0 * vehicle;
  KeyframeState x;
  x.T_odom_body.p = {0.0, y, 0.0};
  x.v_odom_mps = {1.0, 0.0, 0.0};
  for (int k = 0; k < nodes; ++k) {
    const bool state = is_degenerate(k) || is_degenerate(k + 1);
    const bool degenerate = is_degenerate(k);
    RelativePoseFactor lidar;
    lidar.T_i_j.p = {1.0 + 0.01 * rng.normal(), 0.005 * rng.normal(), 0.005 * rng.normal()};
    lidar.information.diagonal() << 8e6, 8e6, 8e6, degenerate ? 0.0 : 1e4, 4e4, 4e4;
    if (k > 0) x.T_odom_body = x.T_odom_body * lidar.T_i_j;
    const Seq seq = state ? graph.add_state(x) : graph.add_pose(x.T_odom_body);
    if (k == 0) {
      graph.add_pose_prior(seq, x.T_odom_body, 1e4 * geometry::Mat6::Identity());
      continue;
    }
    lidar.i = seq - 1;
    lidar.j = seq;
    graph.add(lidar);
    if (degenerate) graph.add(even_second(seq - 1, rng));
  }
}

PoseGraph fleet(int vehicles, int nodes) {
  PoseGraph graph{GraphSettings{}};
  Rng rng(3, "fleet");
  for (int v = 0; v < vehicles; ++v) add_path(graph, v, nodes, rng);
  std::uint64_t id = 0;
  for (int a = 0; a < vehicles; ++a) {
    for (int b = 0; b < a; ++b) {
      const auto pair = static_cast<int>(id);
      graph.add_bias(pair, 0.0, 0.15);
      for (int k = 0; k < nodes; ++k) {
        RangeFactor f;
        f.id = id++;
        f.i = static_cast<Seq>(a * nodes + k);
        f.other.emplace();
        f.other->i = static_cast<Seq>(b * nodes + k);
        f.range_m = 3.0 * (a - b) + 0.1 * rng.normal();
        f.bias = pair;
        graph.add(f);
      }
    }
  }
  return graph;
}

PoseGraph fleet(const benchmark::State& state) {
  return fleet(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
}

void solve_fleet(benchmark::State& state) {
  int iterations = 0;
  const PoseGraph start = fleet(state);
  for (auto _ : state) {
    state.PauseTiming();
    PoseGraph graph = start;
    state.ResumeTiming();
    iterations = graph.solve_full().iterations;
  }
  state.counters["iterations"] = iterations;
}

void covariances_of_all(benchmark::State& state) {
  PoseGraph graph = fleet(state);
  graph.solve_full();
  for (auto _ : state) {
    state.PauseTiming();
    PoseGraph fresh = graph;
    state.ResumeTiming();
    benchmark::DoNotOptimize(fresh.covariances());
  }
}

void judge_loops_of_fleet(benchmark::State& state) {
  PoseGraph graph = fleet(state);
  graph.solve_full();
  std::vector<RelativePoseFactor> loops(100);
  for (std::size_t k = 0; k < loops.size(); ++k) {
    loops[k].i = static_cast<Seq>(k);
    loops[k].j = static_cast<Seq>(k + 300);
    loops[k].T_i_j = graph.pose(loops[k].i).inverse() * graph.pose(loops[k].j);
    loops[k].information = 400.0 * geometry::Mat6::Identity();
  }
  SerialExecutor executor;
  for (auto _ : state) benchmark::DoNotOptimize(graph.judge(loops, executor));
}

/// The sparsity pattern of such a fleet: paths, a range between every two vehicles at each node,
/// and the biases of the pairs. Diagonally dominant, so that every solver can factor it.
BlockMatrix matrix_of_fleet(int vehicles, int nodes) {
  std::vector<int> dims;
  std::vector<std::pair<int, int>> pairs;
  for (int v = 0; v < vehicles; ++v) {
    for (int k = 0; k < nodes; ++k) {
      dims.push_back(is_degenerate(k) || is_degenerate(k + 1) ? kStateDim : kPoseDim);
      if (k > 0) pairs.emplace_back(v * nodes + k, v * nodes + k - 1);
    }
  }
  for (int a = 0; a < vehicles; ++a) {
    for (int b = 0; b < a; ++b) {
      const auto bias = static_cast<int>(dims.size());
      dims.push_back(1);
      for (int k = 0; k < nodes; ++k) {
        pairs.emplace_back(a * nodes + k, b * nodes + k);
        pairs.emplace_back(bias, a * nodes + k);
        pairs.emplace_back(bias, b * nodes + k);
      }
    }
  }
  BlockMatrix H(dims, pairs);
  Rng rng(4, "matrix");
  for (const BlockMatrix::Entry& e : H.entries()) {
    BlockMatrix::Block block = H.block(e.row, e.column);
    for (Eigen::Index c = 0; c < block.cols(); ++c) {
      for (Eigen::Index r = 0; r < block.rows(); ++r) block(r, c) = rng.normal();
    }
    if (e.row != e.column) continue;
    block = (0.5 * (block + block.transpose())).eval();
    block.diagonal().array() += 1e5;
  }
  return H;
}

BlockMatrix matrix_of_fleet(const benchmark::State& state) {
  return matrix_of_fleet(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
}

std::vector<int> biases_of(const BlockMatrix& H) {
  std::vector<int> biases;
  for (int v = 0; v < H.variables(); ++v) {
    if (H.dim(v) == 1) biases.push_back(v);
  }
  return biases;
}

void factorise_blocks(benchmark::State& state) {
  const BlockMatrix H = matrix_of_fleet(state);
  BlockCholesky cholesky(H, biases_of(H));
  const Eigen::VectorXd right =
      Eigen::VectorXd::Ones(std::accumulate(H.dims().begin(), H.dims().end(), Eigen::Index{0}));
  for (auto _ : state) {
    if (!cholesky.factorise(H, 0.0, 0.0)) state.SkipWithError("not positive");
    benchmark::DoNotOptimize(cholesky.solve(right));
  }
  state.counters["factor"] = static_cast<double>(cholesky.stored());
}

Eigen::SparseMatrix<double> sparse_of(const BlockMatrix& H) {
  std::vector<int> first(1, 0);
  for (const int dim : H.dims()) first.push_back(first.back() + dim);
  std::vector<Eigen::Triplet<double>> entries;
  for (const BlockMatrix::Entry& e : H.entries()) {
    const auto block = H.block(e);
    for (int c = 0; c < block.cols(); ++c) {
      for (int r = e.row == e.column ? c : 0; r < block.rows(); ++r) {
        entries.emplace_back(first[static_cast<std::size_t>(e.row)] + r,
                             first[static_cast<std::size_t>(e.column)] + c, block(r, c));
      }
    }
  }
  Eigen::SparseMatrix<double> sparse(first.back(), first.back());
  sparse.setFromTriplets(entries.begin(), entries.end());
  return sparse;
}

/// The same by Eigen's SimplicialLLT, its pattern analysed in advance.
void factorise_simplicial(benchmark::State& state) {
  const Eigen::SparseMatrix<double> H = sparse_of(matrix_of_fleet(state));
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> cholesky;
  cholesky.analyzePattern(H);
  const Eigen::VectorXd right = Eigen::VectorXd::Ones(H.rows());
  for (auto _ : state) {
    cholesky.factorize(H);
    if (cholesky.info() != Eigen::Success) state.SkipWithError("not positive");
    benchmark::DoNotOptimize(cholesky.solve(right).eval());
  }
  state.counters["factor"] =
      static_cast<double>(Eigen::SparseMatrix<double>(cholesky.matrixL()).nonZeros());
}

BENCHMARK(factorise_blocks)
    ->Args({2, 400})
    ->Args({4, 600})
    ->Args({4, 3200})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(factorise_simplicial)
    ->Args({2, 400})
    ->Args({4, 600})
    ->Args({4, 3200})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(solve_fleet)
    ->Args({4, 200})
    ->Args({4, 600})
    ->Args({4, 1800})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(covariances_of_all)->Args({4, 500})->Unit(benchmark::kMillisecond);
BENCHMARK(judge_loops_of_fleet)->Args({4, 600})->Unit(benchmark::kMillisecond);
}  // namespace
}  // namespace rali::graph

BENCHMARK_MAIN();
