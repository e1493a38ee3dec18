#include <cstdio>

#include <fmt/format.h>

#include "arguments.hpp"
#include "table.hpp"

namespace rali::recognition {
namespace {

struct Scenery {
  std::string name;
  std::vector<Piece> pieces;
};

Result<Scenery> make(const Arguments& a, sim::Scene scene, std::uint64_t seed) {
  RecordOptions record_options = a.record;
  record_options.scene = scene;
  record_options.seed = seed;
  const auto keyframes = record(record_options, a.cache_dir);
  if (!keyframes) return tl::make_unexpected(keyframes.error());
  auto pieces = cut(*keyframes, a.piece, a.settings);
  if (!pieces) return tl::make_unexpected(pieces.error());
  std::string name = fmt::format("{} {}", sim::kSceneNames[static_cast<std::size_t>(scene)], seed);
  fmt::print(stderr, "{}: {} keyframes, {} pieces\n", name, keyframes->size(), pieces->size());
  return Scenery{std::move(name), std::move(*pieces)};
}

Status main_with(const Arguments& a) {
  std::vector<Figures> figures;
  std::vector<Stages> far;
  for (const sim::Scene scene : a.scenes) {
    for (const std::uint64_t seed : a.seeds) {
      const auto made = make(a, scene, seed);
      if (!made) return tl::make_unexpected(made.error());
      if (a.stages) {
        far.push_back(stages(made->name, made->pieces, a.settings, a.record.halves,
                             a.study.pairs_max, a.study.verbose));
      } else {
        figures.push_back(study(made->name, made->pieces, a.settings, a.study));
      }
    }
  }
  fmt::print("{}", a.stages ? table_of(far) : tables(figures));
  return {};
}

}  // namespace
}  // namespace rali::recognition

/// Exit code: 0 done, 2 wrong arguments.
int main(int argc, char** argv) {
  const auto arguments = rali::recognition::parse_arguments(argc, argv);
  if (!arguments) return arguments.error();
  if (auto ok = rali::recognition::main_with(*arguments); !ok) {
    fmt::print(stderr, "{}\n", ok.error().message());
    return 2;
  }
  return 0;
}
