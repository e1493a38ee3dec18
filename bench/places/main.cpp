#include <cstdio>

#include <fmt/format.h>

#include "arguments.hpp"
#include "table.hpp"

namespace rali::recognition {
namespace {

Result<Figures> run(const Arguments& a, sim::Scene scene, std::uint64_t seed) {
  RecordOptions record_options = a.record;
  record_options.scene = scene;
  record_options.seed = seed;
  const auto keyframes = record(record_options, a.cache_dir);
  if (!keyframes) return tl::make_unexpected(keyframes.error());
  const auto pieces = cut(*keyframes, a.piece, a.settings);
  if (!pieces) return tl::make_unexpected(pieces.error());
  const std::string name =
      fmt::format("{} {}", sim::kSceneNames[static_cast<std::size_t>(scene)], seed);
  fmt::print(stderr, "{}: {} keyframes, {} pieces\n", name, keyframes->size(), pieces->size());
  return study(name, *pieces, a.settings, a.study);
}

Status main_with(const Arguments& a) {
  std::vector<Figures> figures;
  for (const sim::Scene scene : a.scenes) {
    for (const std::uint64_t seed : a.seeds) {
      auto done = run(a, scene, seed);
      if (!done) return tl::make_unexpected(done.error());
      figures.push_back(std::move(*done));
    }
  }
  fmt::print("{}", tables(figures));
  return {};
}

}  // namespace
}  // namespace rali::recognition

/// Exit code: 0 done, 2 wrong arguments.
int main(int argc, char** argv) {
  const auto arguments = rali::recognition::parse_arguments(argc, argv);
  if (!arguments) {
    fmt::print(stderr, "{}\n", arguments.error().message());
    return 2;
  }
  if (arguments->help) {
    fmt::print("{}", rali::recognition::help_text());
    return 0;
  }
  if (auto ok = rali::recognition::main_with(*arguments); !ok) {
    fmt::print(stderr, "{}\n", ok.error().message());
    return 2;
  }
  return 0;
}
