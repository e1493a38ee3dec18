// Cost of decoding one scan of 16 x 1800 = 28 800 points, per layout. items_per_second is points.
#include <benchmark/benchmark.h>

#include "rali/wire/cloud_pack.hpp"
#include "rali/wire/decode.hpp"
#include "rali/wire/encode.hpp"
#include "rali/wire/internal/test_scan.hpp"

namespace rali::wire {
namespace {

constexpr std::size_t kColumns = 1800;

void decode(benchmark::State& state, CloudStyle style, bool big_endian) {
  const auto scan = internal::vlp16_scan(Time::from_s(1.7e9), kColumns);
  const PackedCloud cloud = pack_cloud(scan, "lidar", style, HeaderStamp::kStart, big_endian);
  const CloudFormatOptions options;
  const CloudFormat format = decide_cloud_format(std::span(&cloud.view, 1), options).value();
  const Bytes message = encode(cloud.view, Encoding::kCdr);
  sensor::LidarScan decoded;
  for (auto _ : state) {
    const CloudView view = decode_point_cloud2(message, Encoding::kCdr).value();
    benchmark::DoNotOptimize(decode_cloud(view, format, options, decoded).has_value());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(decoded.size()));
}

void decide(benchmark::State& state) {
  const auto scan = internal::vlp16_scan(Time::from_s(1.7e9), kColumns);
  const PackedCloud cloud = pack_cloud(scan, "lidar", CloudStyle::kVelodyne);
  for (auto _ : state) {
    benchmark::DoNotOptimize(decide_cloud_format(std::span(&cloud.view, 1), {}).has_value());
  }
}

BENCHMARK_CAPTURE(decode, velodyne, CloudStyle::kVelodyne, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(decode, robosense, CloudStyle::kRoboSense, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(decode, ouster, CloudStyle::kOuster, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(decode, livox, CloudStyle::kLivox, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(decode, velodyne_big_endian, CloudStyle::kVelodyne, true)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(decode, xyzi_by_azimuth_and_elevation, CloudStyle::kXyzi, false)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(decide)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rali::wire

BENCHMARK_MAIN();
