#include "arguments.hpp"

#include <charconv>

#include <fmt/format.h>

#include "common/words.hpp"
#include "rali/config/apply.hpp"

namespace rali::recognition {
namespace {

template <class T>
Status set_number(const std::string& name, const std::string& text, T low, T high, T& out) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < low || value > high) {
    return fail(ErrorCode::kUsage, name,
                fmt::format("\"{}\" is not a number from {} to {}", text, low, high));
  }
  out = value;
  return {};
}

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

Status set_one(const std::string& name, const std::string& text, Arguments& a) {
  if (name == "--scenes") return set_scenes(text, a);
  if (name == "--lidar") return set_lidar(text, a);
  if (name == "--set") return set_places(text, a);
  if (name == "--vehicles") return set_number(name, text, 1, 8, a.record.vehicles);
  if (name == "--pedestrians") return set_number(name, text, 0, 50, a.record.pedestrians);
  if (name == "--duration") return set_number(name, text, 10.0, 3600.0, a.record.duration_s);
  if (name == "--length") return set_number(name, text, 0.0, 100.0, a.piece.length_m);
  if (name == "--pairs") {
    return set_number<std::size_t>(name, text, 1, 100000, a.study.pairs_max);
  }
  if (name == "--guess") return set_number(name, text, 0.0, 20.0, a.study.guess_m);
  if (name == "--seeds") {
    auto seeds = bench::parse_seeds(text);
    if (!seeds) return tl::make_unexpected(seeds.error());
    a.seeds = std::move(*seeds);
    return {};
  }
  if (name == "--cache") {
    a.cache_dir = text;
    return {};
  }
  return fail(ErrorCode::kUsage, name, "there is no such option", "See --help.");
}

}  // namespace

Result<Arguments> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  for (int k = 1; k < argc; ++k) {
    const std::string name = argv[k];
    if (name == "--help") {
      a.help = true;
    } else if (name == "--verbose") {
      a.study.verbose = true;
    } else if (name == "--stages") {
      a.stages = true;
    } else if (name == "--halves") {
      a.record.halves = true;
    } else if (k + 1 == argc) {
      return fail(ErrorCode::kUsage, name, "the option needs a value", "See --help.");
    } else if (auto ok = set_one(name, argv[++k], a); !ok) {
      return tl::make_unexpected(ok.error());
    }
  }
  return a;
}

std::string help_text() {
  return "places: recognises places on simulated ways and prints what was found and what was "
         "wrong.\n\n"
         "  --scenes a,b       corridor,floor,loop,yard,garage,tunnel\n"
         "  --seeds 1,2        places of each kind\n"
         "  --vehicles N       in one place, 2\n"
         "  --stages           how far pairs of one place come without a guess, instead\n"
         "  --halves           one vehicle's recording cut into two that overlap\n"
         "  --lidar NAME       rs16\n"
         "  --pedestrians N    0\n"
         "  --duration S       of each drive, 100\n"
         "  --length M         of path in one submap, 10\n"
         "  --pairs N          of each kind that are tried, 60\n"
         "  --guess M          error of the guess, 1\n"
         "  --set key=value    a setting of the room\n"
         "  --cache DIR        keeps the keyframes there\n"
         "  --verbose          prints each wrong one\n";
}

}  // namespace rali::recognition
