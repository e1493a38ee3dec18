#include "arguments.hpp"

#include <fmt/format.h>

#include "common/command_line.hpp"
#include "common/words.hpp"

namespace rali::fleet_bench {

namespace {

Status set_scenes(const std::string& text, Arguments& a) {
  a.scenes = bench::split(text);
  for (const std::string& name : a.scenes) {
    Place place;
    place.scene = name;
    if (from_file(place)) continue;
    if (const auto scene = sim::scene_of(name); !scene) return tl::make_unexpected(scene.error());
  }
  return {};
}

/// starts: measured by hand. none: the fleet mapper has no priors. places: no common clock either.
Status set_rows(const std::string& text, Arguments& a) {
  a.rows.clear();
  for (const std::string& name : bench::split(text)) {
    if (name != "starts" && name != "none" && name != "places") {
      return fail(ErrorCode::kUsage, "--rows", fmt::format("there is no row \"{}\"", name),
                  "starts, none or places.");
    }
    a.rows.push_back({name, name == "starts", name != "places", false, {}});
  }
  return {};
}

void add_places(CLI::App& app, Arguments& a) {
  bench::add_text(
      app, "--scenes", [&a](const std::string& text) { return set_scenes(text, a); },
      "corridor,floor or loop, yard, garage, tunnel, mine, ...; or a file with a scene "
      "(docs/reference/scenes.md), FILE.yaml");
  bench::add_seeds(app, a.seeds);
  app.add_flag("--known", a.place.known, "the vehicles get the start poses, too, as by fleet.yaml");
  app.add_flag("--halves", a.place.halves, "one vehicle's recording cut into two that overlap");
  app.add_option("--common", a.place.common,
                 "fraction of the recording's time that both halves have; default: 0.2")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--vehicles", a.place.vehicles, "default: as many as the scene is made for")
      ->check(CLI::PositiveNumber);
  app.add_option("--pedestrians", a.place.pedestrians, "default: 6")->check(CLI::NonNegativeNumber);
  app.add_option("--duration", a.place.duration_s,
                 "the first seconds of each mission; 0: all rounds")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--vehicle-set", a.place.settings,
                 "KEY=VALUE of the vehicles, e.g. vehicle.facts.spacing_m=0.3");
}

void add_outputs(CLI::App& app, Arguments& a) {
  app.add_flag("--mesh", a.mesh, "compare the merged map with the world, too");
  app.add_flag("--per-run", a.per_run, "one row for each run besides the summary");
  app.add_flag("--per-round", a.per_round, "and one for each of its rounds");
  app.add_option("--cache", a.cache_dir, "keep missions there (10 to 200 MB each)");
  app.add_option("--dump", a.dump_dir, "errors of loops and keyframes (CSV)");
  bench::add_into(app, "fleet_bench", a.into);
}

}  // namespace

tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  if (auto ok = set_rows("starts,none", a); !ok) return tl::make_unexpected(bench::wrong(ok));
  a.words.assign(argv + 1, argv + argc);
  CLI::App app("fleet_bench: one map of several vehicles, in simulated places");
  add_places(app, a);
  bench::add_text(
      app, "--rows", [&a](const std::string& text) { return set_rows(text, a); },
      "starts,none: what the joint map gets: start poses by hand (0.2 m, 3 deg); nothing; places: "
      "nothing, and clocks are not common");
  app.add_option("--set", a.settings, "KEY=VALUE of the joint map, e.g. fleet.loops.use=false");
  add_outputs(app, a);
  if (const auto code = bench::ended_by(app, argc, argv)) return tl::make_unexpected(*code);
  for (JoinOptions& row : a.rows) {
    row.settings = a.settings;
    row.by_rounds = a.per_round;
  }
  return a;
}

}  // namespace rali::fleet_bench
