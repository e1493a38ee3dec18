#include "arguments.hpp"

#include <charconv>
#include <functional>
#include <map>

#include <fmt/format.h>

#include "place.hpp"
#include "rali/config/apply.hpp"

namespace rali::blindness {

namespace {

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> out;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    if (end > begin) out.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

template <class T>
Result<T> number(const std::string& text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < T{}) {
    return fail(ErrorCode::kUsage, {}, fmt::format("\"{}\" is not a number of this kind", text));
  }
  return value;
}

/// "1,2,5-8"
Status set_seeds(const std::string& text, Arguments& a) {
  a.seeds.clear();
  for (const std::string& part : split(text)) {
    const std::size_t dash = part.find('-');
    const auto first = number<std::uint64_t>(part.substr(0, dash));
    const auto last =
        dash == std::string::npos ? first : number<std::uint64_t>(part.substr(dash + 1));
    if (!first) return tl::make_unexpected(first.error());
    if (!last) return tl::make_unexpected(last.error());
    for (std::uint64_t s = *first; s <= *last && a.seeds.size() < 1000; ++s) a.seeds.push_back(s);
  }
  if (a.seeds.empty()) return fail(ErrorCode::kUsage, "--seeds", "there is no seed in the list");
  return {};
}

Status set_lidars(const std::string& text, Arguments& a) {
  a.lidars.clear();
  for (const std::string& name : split(text)) {
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

using Setter = std::function<Status(const std::string&, Arguments&)>;

const std::map<std::string, Setter>& setters() {
  static const std::map<std::string, Setter> kSetters{
      {"--seeds", set_seeds},
      {"--lidars", set_lidars},
      {"--set", set_robust},
      {"--places",
       [](const std::string& v, Arguments& a) -> Status {
         a.places = split(v);
         return {};
       }},
      {"--way",
       [](const std::string& v, Arguments& a) -> Status {
         const auto way = number<int>(v);
         if (!way) return tl::make_unexpected(way.error());
         a.way_m = *way;
         return {};
       }},
      {"--pedestrians",
       [](const std::string& v, Arguments& a) -> Status {
         const auto n = number<int>(v);
         if (!n) return tl::make_unexpected(n.error());
         a.pedestrians = *n;
         return {};
       }},
      {"--json",
       [](const std::string& v, Arguments& a) -> Status {
         a.json = v;
         return {};
       }},
      {"--into", [](const std::string& v, Arguments& a) -> Status {
         a.into = v;
         return {};
       }}};
  return kSetters;
}

}  // namespace

Result<Arguments> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  for (const std::string_view place : kPlaces) a.places.emplace_back(place);
  a.words.assign(argv + 1, argv + argc);
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--help" || name == "-h") {
      a.help = true;
      return a;
    }
    if (name == "--alone") {
      a.others = false;
    } else if (const auto setter = setters().find(name); setter == setters().end()) {
      return fail(ErrorCode::kUsage, {}, fmt::format("there is no option \"{}\"", name),
                  "--help lists the options.");
    } else if (i + 1 == argc) {
      return fail(ErrorCode::kUsage, name, "this option needs a value");
    } else if (auto ok = setter->second(argv[++i], a); !ok) {
      return tl::make_unexpected(ok.error());
    }
  }
  return a;
}

std::string help_text() {
  return "degeneracy: detectors of blind directions against what registration achieves\n"
         "  --places tunnel,mine     default: tunnel, tunnel_niches, tunnel_end, tunnel_rough,\n"
         "                           corridor, floor, loop, garage, yard, mine, hall\n"
         "  --seeds 1,2,5-8          default: 1-3\n"
         "  --lidars rs16,os1_64     default: rs16,hdl32e,os1_64 (16, 32, 64 rings)\n"
         "  --pedestrians N          default: 4\n"
         "  --way M                  metres of each drive, default: 60\n"
         "  --alone                  not the tunnels with another vehicle in view\n"
         "  --set key=value          of preset robust, e.g. aware.kappa=4\n"
         "  --json FILE              every scan with every score\n"
         "  --into FILE:NAME         the tables also between '<!-- degeneracy NAME -->' and\n"
         "                           '<!-- end -->' of a Markdown file\n";
}

}  // namespace rali::blindness
