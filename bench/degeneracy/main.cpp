#include <array>
#include <cstdio>
#include <iterator>

#include <fmt/format.h>

#include "arguments.hpp"
#include "common/document.hpp"
#include "sample.hpp"
#include "table.hpp"

namespace rali::degeneracy_bench {
namespace {

constexpr double kMask_m = 1.8;  // a vehicle with its mast and smeared edge points

std::string place_of(const DriveOptions& o) {
  std::string name = o.place;
  if (o.other == Other::kAhead) name += " + vehicle ahead";
  if (o.other == Other::kStanding) name += " + standing vehicle";
  return name;
}

Status run(const DriveOptions& options, const odometry::RobustSettings& settings,
           std::vector<Sample>& out) {
  const int rings = sim::LidarModel(options.lidar).rings();
  Judge seen(settings, place_of(options), options.seed, rings, 0.0);
  Judge masked(settings, place_of(options), options.seed, rings, kMask_m);
  const bool both = options.other != Other::kNobody;
  const auto ok = drive(options, [&](const Station& station, const sensor::Calibration& c) {
    seen.add(station, c);
    if (both) masked.add(station, c);
  });
  if (!ok) return ok;
  fmt::print(stderr, "{} {} {}: {} scans\n", place_of(options), options.seed,
             sim::kLidarNames[static_cast<std::size_t>(options.lidar)], seen.samples().size());
  for (Judge* judge : {&seen, &masked}) {
    std::move(judge->samples().begin(), judge->samples().end(), std::back_inserter(out));
  }
  return {};
}

Status run_all(const Arguments& a, std::vector<Sample>& samples) {
  for (const sim::Lidar lidar : a.lidars) {
    for (const std::uint64_t seed : a.seeds) {
      for (const std::string& place : a.places) {
        for (const Other other : {Other::kNobody, Other::kAhead, Other::kStanding}) {
          if (other != Other::kNobody && (!a.others || place != "tunnel")) continue;
          const DriveOptions options{place, lidar, seed, other, a.pedestrians, a.distance_m};
          if (auto ok = run(options, a.robust, samples); !ok) return ok;
        }
      }
    }
  }
  return {};
}

Status main_with(const Arguments& a) {
  std::vector<Sample> samples;
  if (auto ok = run_all(a, samples); !ok) return ok;
  const std::string text = detector_table(samples) + "\n" + place_table(samples);
  fmt::print("{}", text);
  if (!a.json.empty()) {
    if (auto ok = bench::write_file(a.json, json_of(samples)); !ok) return ok;
  }
  if (a.into.empty()) return {};
  const std::string command = bench::command_of("degeneracy", a.words, {"--json", "--into"});
  return bench::write_into(a.into, "degeneracy", command, text);
}

}  // namespace
}  // namespace rali::degeneracy_bench

/// Exit code: 0 done, 2 wrong arguments or a file that cannot be written.
int main(int argc, char** argv) {
  const auto arguments = rali::degeneracy_bench::parse_arguments(argc, argv);
  if (!arguments) return arguments.error();
  if (auto ok = rali::degeneracy_bench::main_with(*arguments); !ok) {
    fmt::print(stderr, "{}\n", ok.error().message());
    return 2;
  }
  return 0;
}
