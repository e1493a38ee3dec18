#include "arguments.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/command_line.hpp"
#include "common/words.hpp"
#include "place.hpp"
#include "rali/config/apply.hpp"

namespace rali::degeneracy_bench {

namespace {

Status set_lidars(const std::string& text, Arguments& a) {
  a.lidars.clear();
  for (const std::string& name : bench::split(text)) {
    const auto lidar = sim::lidar_of(name);
    if (!lidar) return tl::make_unexpected(lidar.error());
    a.lidars.push_back(*lidar);
  }
  return {};
}

Status set_robust(const std::string& assignment, Arguments& a) {
  const auto node = config::parse_assignment(assignment);
  if (!node) return tl::make_unexpected(node.error());
  config::FieldList fields;
  config::collect_fields("", a.robust, fields);
  config::Origins origins;
  return config::apply_map(*node, "", "--set", fields, origins);
}

}  // namespace

tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  for (const std::string_view place : kPlaces) a.places.emplace_back(place);
  a.words.assign(argv + 1, argv + argc);
  CLI::App app("degeneracy: detectors of degenerate directions against what registration achieves");
  const std::string places = fmt::format("default: {}", fmt::join(kPlaces, ","));
  app.add_option("--places", a.places, places)->delimiter(',');
  bench::add_seeds(app, a.seeds);
  bench::add_text(
      app, "--lidars", [&a](const std::string& text) { return set_lidars(text, a); },
      "default: rs16,hdl32e,os1_64 (16, 32, 64 rings)");
  app.add_option("--pedestrians", a.pedestrians, "who walk about; default: 4")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--distance", a.distance_m, "of each drive [m]; default: 60")
      ->check(CLI::NonNegativeNumber);
  app.add_flag_callback(
      "--alone", [&a] { a.others = false; }, "not the tunnels with another vehicle in view");
  bench::add_texts(
      app, "--set", [&a](const std::string& text) { return set_robust(text, a); },
      "KEY=VALUE of preset robust, e.g. aware.kappa=4");
  app.add_option("--json", a.json, "file with every scan and every score");
  bench::add_into(app, "degeneracy", a.into);
  if (const auto code = bench::ended_by(app, argc, argv)) return tl::make_unexpected(*code);
  return a;
}

}  // namespace rali::degeneracy_bench
