#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "common/command_line.hpp"
#include "common/document.hpp"
#include "parts.hpp"

namespace rali::frames_bench {
namespace {

struct Arguments {
  std::string part, data_dir, into;
  int number = 0;
  std::vector<std::string> words;
};

/// The arguments, or the exit code with which the program ends.
tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  a.words.assign(argv + 1, argv + argc);
  CLI::App app("frames: frames between vehicles, as tables");
  app.require_subcommand(1);
  app.fallthrough();
  app.add_option("--data", a.data_dir, "holds range_slam; default: RALI_DATA_DIR");
  bench::add_into(app, "frames", a.into);
  const auto counted = [&](const char* name, const char* help) {
    CLI::App* part = app.add_subcommand(name, help);
    part->add_option("N", a.number, "runs")->required()->check(CLI::Range(1, 100000));
  };
  counted("geometries", "each geometry in which ranges place a vehicle, N runs each");
  counted("starts", "N random starts of fleets, with and without prior");
  app.add_subcommand("recorded", "recorded fleets with unknown start frames");
  if (const auto code = bench::ended_by(app, argc, argv)) return tl::make_unexpected(*code);
  a.part = app.get_subcommands().front()->get_name();
  return a;
}

Result<std::string> table(const Arguments& a) {
  if (a.part == "geometries") return geometry_table(a.number);
  if (a.part == "starts") return start_table(a.number);
  const char* from_user = std::getenv("RALI_DATA_DIR");
  const std::filesystem::path data = !a.data_dir.empty()    ? a.data_dir
                                     : from_user != nullptr ? from_user
                                                            : RALI_DATA_DIR;
  if (!std::filesystem::is_directory(data / "range_slam")) {
    return fail(ErrorCode::kInput, data.string(), "NO DATA, NOT MEASURED: range_slam is not there",
                "--data or RALI_DATA_DIR says where.");
  }
  return recorded_table(data / "range_slam");
}

int main_with(const Arguments& a) {
  const auto text = table(a);
  if (!text) {
    fmt::print(stderr, "{}\n", text.error().message());
    return 1;
  }
  fmt::print("{}", *text);
  if (a.into.empty()) return 0;
  const std::string command = bench::command_of("frames", a.words, {"--data", "--into"});
  const Status written = bench::write_into(a.into, "frames", command, *text);
  return written ? 0 : bench::wrong(written);
}

}  // namespace
}  // namespace rali::frames_bench

int main(int argc, char** argv) {
  const auto arguments = rali::frames_bench::parse_arguments(argc, argv);
  return arguments ? rali::frames_bench::main_with(*arguments) : arguments.error();
}
