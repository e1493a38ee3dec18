// Preset paper: cost of one scan of 28,800 points (16 rings) on one core.
#include <vector>

#include <benchmark/benchmark.h>

#include "rali/odometry/paper/octree.hpp"
#include "rali/odometry/paper/paper_odometry.hpp"
#include "rali/odometry/paper/planar_features.hpp"
#include "rali/odometry/paper/testing/synthetic_room.hpp"

namespace {

using namespace rali;
using odometry::paper::testing::Drive;
using odometry::paper::testing::Imu;
using odometry::paper::testing::Lidar;
using odometry::paper::testing::Room;
using odometry::paper::testing::scan;

void feature_extraction(benchmark::State& state) {
  Rng rng(1);
  const sensor::LidarScan scan = odometry::paper::testing::scan(Room{}, Drive{}, Lidar{}, 1.0, rng);
  odometry::paper::PlanarFeatureExtractor extractor;
  odometry::paper::PlanarFeatures features;
  for (auto _ : state) {
    extractor.extract(odometry::paper::view_of(scan), {}, features);
    benchmark::DoNotOptimize(features.nx.data());
  }
  state.counters["points"] = static_cast<double>(scan.size());
  state.counters["features"] = static_cast<double>(features.size());
}

BENCHMARK(feature_extraction)->Unit(benchmark::kMillisecond);

void whole_scan(benchmark::State& state) {
  Rng rng(1);
  const Drive drive;
  const Imu imu;
  std::vector<sensor::LidarScan> scans;
  std::vector<sensor::ImuSample> samples;
  for (int k = 1; k <= 40; ++k) scans.push_back(scan(Room{}, drive, Lidar{}, 0.1 * k, rng));
  for (int k = 0; k <= 810; ++k) samples.push_back(imu.sample(drive, 0.005 * k, rng));
  SerialExecutor executor;
  for (auto _ : state) {
    const auto odometry = odometry::make_paper_odometry({}, {}, true);
    FindingList findings;
    for (const auto& sample : samples) odometry->add_imu(sample);
    for (const auto& scan : scans) {
      benchmark::DoNotOptimize(odometry->process(scan, executor, findings).T_odom_body.p.data());
    }
  }
  state.counters["per_scan"] = benchmark::Counter(
      static_cast<double>(scans.size()) * static_cast<double>(state.iterations()),
      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

BENCHMARK(whole_scan)->Unit(benchmark::kMillisecond);

void octree_overlap(benchmark::State& state) {
  Rng rng(1);
  const sensor::LidarScan scan = odometry::paper::testing::scan(Room{}, Drive{}, Lidar{}, 1.0, rng);
  odometry::paper::Octree tree;
  tree.build(scan.x_m, scan.y_m, scan.z_m);
  for (auto _ : state) {
    int inside = 0;
    for (std::size_t i = 0; i < scan.size(); i += 10) {
      const Eigen::Vector3f q(scan.x_m[i] + 0.3F, scan.y_m[i], scan.z_m[i]);
      inside += tree.any_within(q, 0.4F) ? 1 : 0;
    }
    benchmark::DoNotOptimize(inside);
  }
}

BENCHMARK(octree_overlap)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
