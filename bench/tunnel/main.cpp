#include <algorithm>
#include <cstdio>
#include <optional>

#include <fmt/format.h>

#include "arguments.hpp"
#include "common/command_line.hpp"
#include "common/document.hpp"
#include "score.hpp"
#include "table.hpp"

namespace rali::tunnel {
namespace {

Place place_of(const Arguments& a, const Row& row, std::uint64_t seed) {
  return {row.on.scene, seed, row.on.anchor, a.lidar, a.duration_s};
}

Result<Scores> run_row(const Arguments& a, const Recording& recording, const Row& row) {
  const auto track = run(recording, row, a.settings);
  if (!track) return tl::make_unexpected(track.error());
  auto scores = score(*track, recording, row);
  if (scores && !a.dump_dir.empty()) dump(a.dump_dir, *track, row, recording.place().seed);
  return scores;
}

/// A run with its row. Runs are executed by world, since rows of one world share its recording, and
/// sorted by row afterwards.
struct Run {
  std::size_t row = 0;
  Scores scores;
};

/// False if a run failed.
bool run_place(const Arguments& a, const Place& place, std::vector<Run>& runs) {
  std::optional<Result<Recording>> recording;
  bool all_done = true;
  for (std::size_t i = 0; i < a.suite.rows.size(); ++i) {
    const Row& row = a.suite.rows[i];
    if (!(place_of(a, row, place.seed) == place)) continue;
    if (!recording) recording.emplace(Recording::make(place, a.cache_dir));
    const auto scores = *recording ? run_row(a, **recording, row)
                                   : Result<Scores>(tl::make_unexpected(recording->error()));
    if (!scores) {
      fmt::print(stderr, "{}, seed {}: {}\n", row.label, place.seed, scores.error().message());
      all_done = false;
      continue;
    }
    fmt::print(stderr, "{}\n", line_of(*scores));
    runs.push_back({i, *scores});
  }
  return all_done;
}

/// Exit code: 0 all runs done, 1 some failed, 2 a file that cannot be written.
int report(const Arguments& a, std::vector<Run> runs, bool all_done) {
  std::stable_sort(runs.begin(), runs.end(),
                   [](const Run& x, const Run& y) { return x.row < y.row; });
  std::vector<Scores> scores;
  for (Run& r : runs) scores.push_back(std::move(r.scores));
  const std::string tables = tables_of(a.suite.name, scores);
  fmt::print("{}", tables);
  Status written;
  if (!a.json.empty()) written = bench::write_file(a.json, json_of(scores));
  if (written && !a.into.empty()) {
    const std::string command =
        bench::command_of("tunnel", a.words, {"--cache", "--into", "--dump", "--json"});
    written = bench::write_into(a.into, "tunnel", command, tables);
  }
  if (!written) return bench::wrong(written);
  return all_done ? 0 : 1;
}

int main_with(const Arguments& a) {
  std::vector<Run> runs;
  bool all_done = true;
  for (const std::uint64_t seed : a.seeds) {
    std::vector<Place> done;
    for (const Row& row : a.suite.rows) {
      const Place place = place_of(a, row, seed);
      if (std::find(done.begin(), done.end(), place) != done.end()) continue;
      done.push_back(place);
      all_done = run_place(a, place, runs) && all_done;
    }
  }
  return report(a, std::move(runs), all_done);
}

}  // namespace
}  // namespace rali::tunnel

int main(int argc, char** argv) {
  const auto arguments = rali::tunnel::parse_arguments(argc, argv);
  return arguments ? rali::tunnel::main_with(*arguments) : arguments.error();
}
