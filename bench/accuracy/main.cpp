#include <cstdio>

#include <fmt/format.h>

#include "arguments.hpp"
#include "common/command_line.hpp"
#include "common/document.hpp"
#include "document.hpp"
#include "table.hpp"

namespace rali::accuracy {
namespace {

/// Exit code: 0 all runs done, 1 some failed, 2 wrong arguments.
int main_with(const Arguments& a) {
  std::vector<Scores> runs;
  bool all_done = true;
  for (const std::string& preset : a.presets) {
    for (const sim::Scene scene : a.scenes) {
      for (const std::uint64_t seed : a.seeds) {
        sim::SimOptions options = a.sim;
        options.scene = scene;
        options.seed = seed;
        auto scores = run(options, {preset, a.cache_dir, a.dump_dir, a.settings});
        if (!scores) {
          fmt::print(stderr, "{} {} {}: {}\n", sim::kSceneNames[static_cast<std::size_t>(scene)],
                     seed, preset, scores.error().message());
          if (scores.error().code == ErrorCode::kUsage) return 2;
          all_done = false;
          continue;
        }
        fmt::print(stderr, "{} {} {}: APE {:.3f} m, {:.1f} ms\n", scores->scene, seed, preset,
                   scores->ape_rmse_m, scores->cpu_ms);
        runs.push_back(std::move(*scores));
      }
    }
  }
  if (a.per_run) fmt::print("{}\n", run_table(runs));
  fmt::print("{}", summary_table(runs));
  if (!a.into.empty()) {
    const Status written =
        bench::write_into(a.into, "accuracy", command_of(a.words), short_table(runs));
    if (!written) return bench::wrong(written);
  }
  return all_done ? 0 : 1;
}

}  // namespace
}  // namespace rali::accuracy

int main(int argc, char** argv) {
  const auto arguments = rali::accuracy::parse_arguments(argc, argv);
  return arguments ? rali::accuracy::main_with(*arguments) : arguments.error();
}
