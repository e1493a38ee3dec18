#include "arguments.hpp"

#include <functional>
#include <map>

#include <fmt/format.h>

#include "common/words.hpp"
#include "rali/config/yaml_tree.hpp"

namespace rali::tunnel {

namespace {

using Setter = std::function<Status(const std::string&, Arguments&)>;

Status set_suite(const std::string& name, Arguments& a) {
  auto suite = suite_of(name);
  if (!suite) return tl::make_unexpected(suite.error());
  a.suite = std::move(*suite);
  return {};
}

/// Rows by their numbers, from 1.
Status set_rows(const std::string& text, Arguments& a) {
  const auto numbers = bench::parse_seeds(text);
  if (!numbers) return tl::make_unexpected(numbers.error());
  std::vector<Row> rows;
  for (const std::uint64_t n : *numbers) {
    if (n < 1 || n > a.suite.rows.size()) {
      return fail(ErrorCode::kUsage, "--rows",
                  fmt::format("suite {} has rows 1 to {}", a.suite.name, a.suite.rows.size()));
    }
    rows.push_back(a.suite.rows[n - 1]);
  }
  a.suite.rows = std::move(rows);
  return {};
}

Status set_lidar(const std::string& text, Arguments& a) {
  const auto lidar = sim::lidar_of(text);
  if (!lidar) return tl::make_unexpected(lidar.error());
  a.lidar = *lidar;
  return {};
}

Status set_duration(const std::string& text, Arguments& a) {
  if (config::parse_double(text, a.duration_s) && a.duration_s >= 0.0) return {};
  return fail(ErrorCode::kUsage, "--duration", fmt::format("\"{}\" is no number of seconds", text));
}

Status set_seeds(const std::string& text, Arguments& a) {
  auto seeds = bench::parse_seeds(text);
  if (!seeds) return tl::make_unexpected(seeds.error());
  a.seeds = std::move(*seeds);
  return {};
}

Setter text_into(std::string Arguments::*member) {
  return [member](const std::string& text, Arguments& a) -> Status {
    a.*member = text;
    return {};
  };
}

const std::map<std::string, Setter>& setters() {
  static const std::map<std::string, Setter> kSetters{
      {"--suite", set_suite},
      {"--rows", set_rows},
      {"--seeds", set_seeds},
      {"--lidar", set_lidar},
      {"--duration", set_duration},
      {"--set",
       [](const std::string& text, Arguments& a) -> Status {
         a.settings.push_back(text);
         return {};
       }},
      {"--cache", text_into(&Arguments::cache_dir)},
      {"--dump", text_into(&Arguments::dump_dir)},
      {"--json", text_into(&Arguments::json)},
      {"--into", text_into(&Arguments::into)}};
  return kSetters;
}

/// Before a long recording is cast.
Status check_rows(const Arguments& a) {
  for (const Row& row : a.suite.rows) {
    std::vector<std::string> all = a.settings;
    all.insert(all.end(), row.settings.begin(), row.settings.end());
    if (auto ok = check_settings(all); !ok) return ok;
  }
  return {};
}

}  // namespace

Result<Arguments> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  if (auto ok = set_suite("acceptance", a); !ok) return tl::make_unexpected(ok.error());
  a.words.assign(argv + 1, argv + argc);
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--help" || name == "-h") {
      a.help = true;
      return a;
    }
    const auto setter = setters().find(name);
    if (setter == setters().end()) {
      return fail(ErrorCode::kUsage, {}, fmt::format("there is no option \"{}\"", name),
                  "--help lists the options.");
    }
    if (i + 1 == argc) return fail(ErrorCode::kUsage, name, "this option needs a value");
    if (auto ok = setter->second(argv[++i], a); !ok) return tl::make_unexpected(ok.error());
  }
  if (auto ok = check_rows(a); !ok) return tl::make_unexpected(ok.error());
  return a;
}

std::string help_text() {
  return "tunnel: a vehicle held by ranges to one that stands, in simulated places\n"
         "  --suite acceptance       or harm, ablation, mesh\n"
         "  --rows 1,3-4             these rows of the suite only; after --suite\n"
         "  --seeds 1,2,5-8          default: 101-104\n"
         "  --lidar rs16             or vlp16, hdl32e, hdl64e, os1_64, os0_128, livox\n"
         "  --duration S             the first S seconds of each recording\n"
         "  --set key=value          of the vehicle, e.g. ranging.gate.chi2=6\n"
         "  --cache DIR              keep cast sweeps there (rs16: 90 kB each)\n"
         "  --dump DIR               errors per sweep and per range (CSV)\n"
         "  --json FILE              all figures of all runs\n"
         "  --into FILE:NAME         the tables also between '<!-- tunnel NAME -->' and\n"
         "                           '<!-- end -->' of a Markdown file\n";
}

}  // namespace rali::tunnel
