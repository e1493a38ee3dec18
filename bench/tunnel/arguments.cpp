#include "arguments.hpp"

#include <fmt/format.h>

#include "common/command_line.hpp"
#include "common/words.hpp"

namespace rali::tunnel {

namespace {

Status set_suite(const std::string& name, Arguments& a) {
  auto suite = suite_of(name);
  if (!suite) return tl::make_unexpected(suite.error());
  a.suite = std::move(*suite);
  return {};
}

/// Selects rows by their numbers, from 1.
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

/// Checks settings before a long recording is simulated.
Status check_rows(const Arguments& a) {
  for (const Row& row : a.suite.rows) {
    std::vector<std::string> all = a.settings;
    all.insert(all.end(), row.settings.begin(), row.settings.end());
    if (auto ok = check_settings(all); !ok) return ok;
  }
  return {};
}

/// Selects the requested rows and checks their settings.
Status choose_rows(const std::string& suite, const std::string& rows, Arguments& a) {
  if (auto ok = set_suite(suite, a); !ok) return ok;
  if (!rows.empty()) {
    if (auto ok = set_rows(rows, a); !ok) return ok;
  }
  return check_rows(a);
}

}  // namespace

tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  std::string suite = "acceptance", rows;
  a.words.assign(argv + 1, argv + argc);
  CLI::App app("tunnel: a vehicle constrained by ranges to one that stands, in simulated places");
  app.add_option("--suite", suite, "acceptance, harm, ablation or mesh; default: acceptance");
  app.add_option("--rows", rows, "1,3-4: these rows of the suite only");
  bench::add_seeds(app, a.seeds);
  bench::add_text(
      app, "--lidar", [&a](const std::string& name) { return set_lidar(name, a); },
      "rs16, vlp16, hdl32e, hdl64e, os1_64, os0_128, livox; default: rs16");
  app.add_option("--duration", a.duration_s, "the first seconds of each recording; 0: all")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--set", a.settings, "KEY=VALUE of the vehicle, e.g. ranging.gate.chi2=6");
  app.add_option("--cache", a.cache_dir, "keep cast scans there (rs16: 90 kB each)");
  app.add_option("--dump", a.dump_dir, "errors per scan and per range (CSV)");
  app.add_option("--json", a.json, "file with all figures of all runs");
  bench::add_into(app, "tunnel", a.into);
  if (const auto code = bench::ended_by(app, argc, argv)) return tl::make_unexpected(*code);
  if (auto ok = choose_rows(suite, rows, a); !ok) return tl::make_unexpected(bench::wrong(ok));
  return a;
}

}  // namespace rali::tunnel
