#include "arguments.hpp"

#include <functional>
#include <map>

#include <fmt/format.h>

#include "common/words.hpp"
#include "rali/config/yaml_tree.hpp"

namespace rali::fleet_bench {

namespace {

using Setter = std::function<Status(const std::string&, Arguments&)>;

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

Status set_seeds(const std::string& text, Arguments& a) {
  auto seeds = bench::parse_seeds(text);
  if (!seeds) return tl::make_unexpected(seeds.error());
  a.seeds = std::move(*seeds);
  return {};
}

/// starts: measured by hand. none: the centre knows nothing. places: not even common clocks.
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

Status number(const std::string& name, const std::string& text, double least, double& value) {
  if (config::parse_double(text, value) && value >= least) return {};
  return fail(ErrorCode::kUsage, name, fmt::format("\"{}\" is no number that can be", text));
}

Setter count_into(const std::string& name, int Place::*member, double least) {
  return [name, member, least](const std::string& text, Arguments& a) -> Status {
    double value = 0.0;
    if (auto ok = number(name, text, least, value); !ok) return ok;
    a.place.*member = static_cast<int>(value);
    return {};
  };
}

Setter text_into(std::string Arguments::*member) {
  return [member](const std::string& text, Arguments& a) -> Status {
    a.*member = text;
    return {};
  };
}

const std::map<std::string, Setter>& setters() {
  static const std::map<std::string, Setter> kSetters{
      {"--scenes", set_scenes},
      {"--seeds", set_seeds},
      {"--rows", set_rows},
      {"--vehicles", count_into("--vehicles", &Place::vehicles, 1.0)},
      {"--pedestrians", count_into("--pedestrians", &Place::pedestrians, 0.0)},
      {"--duration",
       [](const std::string& text, Arguments& a) {
         return number("--duration", text, 0.0, a.place.duration_s);
       }},
      {"--common",
       [](const std::string& text, Arguments& a) -> Status {
         if (auto ok = number("--common", text, 0.0, a.place.common); !ok) return ok;
         if (a.place.common <= 1.0) return {};
         return fail(ErrorCode::kUsage, "--common", "a share is at most 1");
       }},
      {"--set",
       [](const std::string& text, Arguments& a) -> Status {
         a.settings.push_back(text);
         return {};
       }},
      {"--vehicle-set",
       [](const std::string& text, Arguments& a) -> Status {
         a.place.settings.push_back(text);
         return {};
       }},
      {"--cache", text_into(&Arguments::cache_dir)},
      {"--dump", text_into(&Arguments::dump_dir)},
      {"--into", text_into(&Arguments::into)}};
  return kSetters;
}

bool take_flag(const std::string& name, Arguments& a) {
  if (name == "--help" || name == "-h") {
    a.help = true;
  } else if (name == "--mesh") {
    a.mesh = true;
  } else if (name == "--per-run") {
    a.per_run = true;
  } else if (name == "--per-round") {
    a.per_round = true;
  } else if (name == "--known") {
    a.place.known = true;
  } else if (name == "--halves") {
    a.place.halves = true;
  } else {
    return false;
  }
  return true;
}

}  // namespace

Result<Arguments> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  if (auto ok = set_rows("starts,none", a); !ok) return tl::make_unexpected(ok.error());
  a.words.assign(argv + 1, argv + argc);
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (take_flag(name, a)) continue;
    const auto setter = setters().find(name);
    if (setter == setters().end()) {
      return fail(ErrorCode::kUsage, {}, fmt::format("there is no option \"{}\"", name),
                  "--help lists the options.");
    }
    if (i + 1 == argc) return fail(ErrorCode::kUsage, name, "this option needs a value");
    if (auto ok = setter->second(argv[++i], a); !ok) return tl::make_unexpected(ok.error());
  }
  for (JoinOptions& row : a.rows) {
    row.settings = a.settings;
    row.by_rounds = a.per_round;
  }
  return a;
}

std::string help_text() {
  return "fleet_bench: one map of several vehicles, in simulated places\n"
         "  --scenes corridor,floor  or loop, yard, garage, tunnel, mine, ...; or a\n"
         "                           file with a scene (docs/reference/scenes.md), FILE.yaml\n"
         "  --seeds 1,2,5-8          default: 401-405\n"
         "  --rows starts,none       what the centre knows: start poses by hand (0.2 m, 3 deg);\n"
         "                           nothing; places: nothing, and clocks are not common\n"
         "  --known                  the vehicles are told the start poses, too, as by fleet.yaml\n"
         "  --halves                 one vehicle's recording cut into two that overlap\n"
         "  --common SHARE           of the recording's time that both halves have; 0.2\n"
         "  --vehicles N             default: as many as the scene is made for\n"
         "  --pedestrians N          default: 6\n"
         "  --duration S             the first S seconds of each mission; 0: all rounds\n"
         "  --mesh                   compare the merged map with the world, too\n"
         "  --per-run                one row for each run besides the summary\n"
         "  --per-round              and one for each of its rounds\n"
         "  --set key=value          of the centre, e.g. fleet.loops.use=false\n"
         "  --vehicle-set key=value  of the vehicles, e.g. vehicle.facts.spacing_m=0.3\n"
         "  --cache DIR              keep missions there (10 to 200 MB each)\n"
         "  --dump DIR               errors of loops and keyframes (CSV)\n"
         "  --into FILE:NAME         the tables also between '<!-- fleet_bench NAME -->' and\n"
         "                           '<!-- end -->' of a Markdown file\n";
}

}  // namespace rali::fleet_bench
