#include "arguments.hpp"

#include "common/command_line.hpp"
#include "common/words.hpp"
#include "rali/config/apply.hpp"

namespace rali::recognition {
namespace {

Status set_scenes(const std::string& text, Arguments& a) {
  a.scenes.clear();
  for (const std::string& name : bench::split(text)) {
    const auto scene = sim::scene_of(name);
    if (!scene) return tl::make_unexpected(scene.error());
    a.scenes.push_back(*scene);
  }
  return {};
}

Status set_lidar(const std::string& text, Arguments& a) {
  const auto lidar = sim::lidar_of(text);
  if (!lidar) return tl::make_unexpected(lidar.error());
  a.record.lidar = *lidar;
  return {};
}

Status set_places(const std::string& assignment, Arguments& a) {
  const auto node = config::parse_assignment(assignment);
  if (!node) return tl::make_unexpected(node.error());
  config::FieldList fields;
  config::collect_fields("", a.settings, fields);
  config::Origins origins;
  return config::apply_map(*node, "", "--set", fields, origins);
}

}  // namespace

tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  CLI::App app("places: recognises places of simulated drives; what was found and what was wrong");
  const auto with = [&a](Status (*set)(const std::string&, Arguments&)) {
    return [set, &a](const std::string& text) { return set(text, a); };
  };
  bench::add_text(app, "--scenes", with(set_scenes),
                  "default: corridor,floor,loop,yard,garage,tunnel");
  bench::add_seeds(app, a.seeds);
  app.add_option("--vehicles", a.record.vehicles, "in one place; default: 2")
      ->check(CLI::Range(1, 8));
  app.add_flag("--stages", a.stages, "how far pairs of one place come without a guess, instead");
  app.add_flag("--halves", a.record.halves, "one vehicle's recording cut into two that overlap");
  bench::add_text(app, "--lidar", with(set_lidar), "default: rs16");
  app.add_option("--pedestrians", a.record.pedestrians, "default: 0")->check(CLI::Range(0, 50));
  app.add_option("--duration", a.record.duration_s, "of each drive [s]; default: 100")
      ->check(CLI::Range(10.0, 3600.0));
  app.add_option("--length", a.piece.length_m, "of path in one submap [m]; default: 10")
      ->check(CLI::Range(0.0, 100.0));
  app.add_option("--pairs", a.study.pairs_max, "of each kind that are tried; default: 60")
      ->check(CLI::Range(1, 100000));
  app.add_option("--guess", a.study.guess_m, "error of the guess [m]; default: 1")
      ->check(CLI::Range(0.0, 20.0));
  bench::add_texts(app, "--set", with(set_places), "KEY=VALUE of the room");
  app.add_option("--cache", a.cache_dir, "keeps the keyframes there");
  app.add_flag("--verbose", a.study.verbose, "prints each wrong one");
  if (const auto code = bench::ended_by(app, argc, argv)) return tl::make_unexpected(*code);
  return a;
}

}  // namespace rali::recognition
