// Speed of the simulator. "faster" is simulated seconds per second of CPU time of all threads;
// the Time column is wall time for 5 simulated seconds (2 for fleets).
#include <benchmark/benchmark.h>

#include "rali/drive/tbb_executor.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::sim {
namespace {

void simulate(benchmark::State& state, Scene scene, Lidar lidar, int vehicles, double span_s) {
  FleetOptions o;
  o.vehicles = vehicles;
  o.vehicle.lidar = lidar;
  o.vehicle.ranging = LidarOptions::of(lidar);
  o.vehicle.duration_s = span_s;
  o.vehicle.motion.standstill_s = 0.0;
  const World world = world_for(make_world(scene, 1), vehicles).value();
  const auto executor = drive::make_executor(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    state.PauseTiming();
    const auto simulation = make_fleet_simulation(world, o).value();
    simulation->use(*executor);
    state.ResumeTiming();
    while (const auto message = simulation->next()) benchmark::DoNotOptimize(message->vehicle);
  }
  state.counters["faster"] = benchmark::Counter(span_s * static_cast<double>(state.iterations()),
                                                benchmark::Counter::kIsRate);
}

void trajectories(benchmark::State& state) {
  const World world = world_for(make_world(Scene::kFloor, 1), 3).value();
  double span_s = 0.0;
  for (auto _ : state) {
    FleetMotion fleet(world, {}, 3, 1);
    benchmark::DoNotOptimize(drive_rounds(fleet, world, 3.0, 4.0).has_value());
    span_s += fleet.time_s();
  }
  state.counters["faster"] = benchmark::Counter(span_s, benchmark::Counter::kIsRate);
}

#define RALI_BENCH(name, ...)                    \
  BENCHMARK_CAPTURE(simulate, name, __VA_ARGS__) \
      ->Arg(1)                                   \
      ->Arg(2)                                   \
      ->MeasureProcessCPUTime()                  \
      ->Unit(benchmark::kMillisecond)

RALI_BENCH(rs16_corridor, Scene::kCorridor, Lidar::kRs16, 1, 5.0);
RALI_BENCH(rs16_mine, Scene::kMine, Lidar::kRs16, 1, 5.0);
RALI_BENCH(os1_64_corridor, Scene::kCorridor, Lidar::kOs1_64, 1, 5.0);
RALI_BENCH(os0_128_corridor, Scene::kCorridor, Lidar::kOs0_128, 1, 5.0);
RALI_BENCH(livox_corridor, Scene::kCorridor, Lidar::kLivox, 1, 5.0);
RALI_BENCH(two_rs16_corridor, Scene::kCorridor, Lidar::kRs16, 2, 2.0);
RALI_BENCH(ten_rs16_corridor, Scene::kCorridor, Lidar::kRs16, 10, 2.0);
BENCHMARK(trajectories)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rali::sim

BENCHMARK_MAIN();
