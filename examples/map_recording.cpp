// Maps recordings as `rali map` does, and compares the result with a ground truth if there is one.
//   map_recording run.bag out
//   map_recording fleet.yaml out truth/
#include <cstdio>
#include <string>

#include <rali/evaluate.hpp>
#include <rali/map.hpp>
#include <rali/results.hpp>

namespace {

int map_and_judge(const std::string& input, const std::string& out, const std::string& truth) {
  const rali::FleetConfig config =
      rali::load_inputs({input}, {"", {{"output.map_voxel_m", "0.1"}}});
  rali::MapOptions options;
  options.out = out;
  rali::MapCallbacks callbacks;
  callbacks.progress = [](const rali::MapProgress& p) {
    std::fprintf(stderr, "%s %s %3.0f %%\n", p.vehicle.c_str(), p.stage.c_str(),
                 100.0 * p.fraction);
    return true;  // false stops the run at the data time reached
  };
  const rali::MapSummary summary = rali::map_recordings(config, options, callbacks);
  for (const rali::VehicleSummary& vehicle : summary.vehicles) {
    std::printf("%s: %.1f m, expected error %.2f m\n", vehicle.name.c_str(), vehicle.distance_m,
                vehicle.sigma_median_m);
  }
  std::printf("map: %zu points\n", rali::read_map(out + "/map.pcd").size());
  if (!truth.empty()) {
    rali::EvaluateOptions judge;
    judge.truth = truth;
    std::printf("error: %.3f m\n", rali::evaluate(out, judge).fleet.ape_m.rmse);
  }
  return summary.gaps ? 3 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: map_recording INPUT OUT [TRUTH]\n");
    return 2;
  }
  try {
    return map_and_judge(argv[1], argv[2], argc > 3 ? argv[3] : "");
  } catch (const rali::InputError& error) {  // where, problem, remedy
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
