#include <cstdio>

#include <fmt/format.h>

#include "arguments.hpp"
#include "cloud.hpp"
#include "common/command_line.hpp"
#include "common/document.hpp"
#include "rounds.hpp"
#include "score.hpp"
#include "table.hpp"

namespace rali::fleet_bench {
namespace {

Result<Scores> run_row(const Arguments& a, const Place& place, const Mission& mission,
                       const JoinOptions& row) {
  const auto joined = join(mission, place.seed, row);
  if (!joined) return tl::make_unexpected(joined.error());
  auto scores = score(mission, *joined, place, row);
  if (!scores) return scores;
  if (a.per_round) {
    fmt::print("{} {}, seed {}\n\n{}\n", name_of(place), row.name, place.seed,
               round_table(mission, *joined));
  }
  if (!a.dump_dir.empty()) dump(a.dump_dir, mission, *joined, *scores);
  if (!a.mesh || scores->joined < 2) return scores;
  const auto world = world_of(place);
  if (!world) return tl::make_unexpected(world.error());
  const auto cloud = compare_cloud(mission, *joined, world->world.mesh);
  if (!cloud) return tl::make_unexpected(cloud.error());
  scores->mesh_m = cloud->within.mean;
  scores->mesh_p95_m = cloud->p95_m;
  return scores;
}

/// False if a run failed.
bool run_place(const Arguments& a, const Place& place, std::vector<Scores>& runs) {
  const auto mission = drive_mission(place, a.cache_dir);
  bool all_done = true;
  for (const JoinOptions& row : a.rows) {
    const auto scores = mission ? run_row(a, place, *mission, row)
                                : Result<Scores>(tl::make_unexpected(mission.error()));
    if (!scores) {
      fmt::print(stderr, "{} {}, seed {}: {}\n", name_of(place), row.name, place.seed,
                 scores.error().message());
      all_done = false;
      continue;
    }
    fmt::print(stderr, "{}\n", line_of(*scores));
    runs.push_back(*scores);
  }
  return all_done;
}

/// Exit code: 0 all runs done, 1 some failed, 2 a file that cannot be written.
int report(const Arguments& a, const std::vector<Scores>& runs, bool all_done) {
  if (a.per_run) fmt::print("{}\n", run_table(runs));
  const std::string tables = tables_of(runs);
  fmt::print("{}", tables);
  if (!a.into.empty()) {
    const std::string command =
        bench::command_of("fleet_bench", a.words, {"--cache", "--into", "--dump"});
    const Status written = bench::write_into(a.into, "fleet_bench", command, tables);
    if (!written) return bench::wrong(written);
  }
  return all_done ? 0 : 1;
}

int main_with(const Arguments& a) {
  std::vector<Scores> runs;
  bool all_done = true;
  for (const std::string& scene : a.scenes) {
    for (const std::uint64_t seed : a.seeds) {
      Place place = a.place;
      place.scene = scene;
      place.seed = seed;
      all_done = run_place(a, place, runs) && all_done;
    }
  }
  return report(a, runs, all_done);
}

}  // namespace
}  // namespace rali::fleet_bench

int main(int argc, char** argv) {
  const auto arguments = rali::fleet_bench::parse_arguments(argc, argv);
  return arguments ? rali::fleet_bench::main_with(*arguments) : arguments.error();
}
