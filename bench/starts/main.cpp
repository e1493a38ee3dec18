// Starts of a vehicle with LiDAR only at every second of a recording (docs/results.md).
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "common/command_line.hpp"
#include "run.hpp"

namespace rali::bench {
namespace {

struct Options {
  std::string folder;
  double step_s = 1.0;
  double last_s = 55.0;
  double first_s = 0.0;
  double duration_s = 7.0;
  double limit_m = 0.15;
  std::vector<std::string> variants = {"forward", "backward", "half", "half_backward"};
  bool poses = false;
  bool all = false;
};

struct Tally {
  int runs = 0, lost = 0, silent = 0;
  double error_max_m = 0.0;  ///< of runs that were not lost
  double silent_max_m = 0.0;
};

std::string reported(const FindingList& findings, Time first) {
  std::string text;
  for (const Finding& f : findings) {
    text += fmt::format(" {} {:.1f}", f.id, (f.t - first).s());
    if (f.t_end.ns > 0) text += fmt::format("-{:.1f}", (f.t_end - first).s());
  }
  return text;
}

void print_poses(const StartRun& run) {
  for (const StartPose& p : run.poses) {
    fmt::print("    {:5.1f} s  {:7.3f} m {:7.2f} deg  sigma {:.3f} m  matches {}{}\n", p.t_s,
               p.error_m, p.error_deg, p.sigma_m, p.matches, p.cut ? "  cut" : "");
  }
}

ReferencedScans variant(const ReferencedScans& scans, const std::string& name) {
  const ReferencedScans some = name.starts_with("half") ? halved(scans) : scans;
  return name.ends_with("backward") ? reversed(some) : some;
}

Tally run_variant(const ReferencedScans& scans, const std::string& name, double duration_s,
                  const Options& options) {
  vehicle::VehicleSettings settings;
  settings.has_imu = false;
  Tally tally;
  for (double start_s = options.first_s; start_s <= options.last_s; start_s += options.step_s) {
    const StartRun run = run_start(scans, {start_s, duration_s}, settings, options.limit_m);
    ++tally.runs;
    tally.lost += run.lost ? 1 : 0;
    tally.silent += run.silent_max_m > 0.0 ? 1 : 0;
    tally.silent_max_m = std::max(tally.silent_max_m, run.silent_max_m);
    if (!run.lost) tally.error_max_m = std::max(tally.error_max_m, run.error_max_m);
    const bool bad = run.lost || run.silent_max_m > 0.0 || !run.findings.empty();
    if (!bad && !options.all) continue;
    Time first = scans.front().scan->t_end + Duration::from_s(start_s);
    fmt::print("  {} start {:.0f} s, {} s: path {:.1f} m, error {:.3f} m, silent {:.3f} m{}{}\n",
               name, start_s, duration_s > 0.0 ? fmt::format("{:.0f}", duration_s) : "all",
               run.path_m, run.error_max_m, run.silent_max_m, run.lost ? ", lost" : "",
               reported(run.findings, first));
    if (options.poses) print_poses(run);
    std::fflush(stdout);
  }
  return tally;
}

int run(const Options& options) {
  const auto scans = read_compact_scans(options.folder);
  if (!scans) {
    fmt::print(stderr, "{}: {}\n", scans.error().where, scans.error().what);
    return 2;
  }
  std::string table =
      "| scans | to | runs | lost | silent | largest error, not lost m | not said m |\n"
      "|---|---|---|---|---|---|---|\n";
  int silent = 0;
  for (const std::string& name : options.variants) {
    for (const double duration_s : {options.duration_s, 0.0}) {
      const Tally t = run_variant(variant(*scans, name), name, duration_s, options);
      table += fmt::format("| {} | {} | {} | {} | {} | {:.3f} | {:.3f} |\n", name,
                           duration_s > 0.0 ? fmt::format("{:.0f} s", duration_s) : "end", t.runs,
                           t.lost, t.silent, t.error_max_m, t.silent_max_m);
      silent += t.silent;
      if (options.duration_s <= 0.0) break;
    }
  }
  fmt::print("{}", table);
  return silent > 0 ? 1 : 0;
}

}  // namespace
}  // namespace rali::bench

int main(int argc, char** argv) {
  rali::bench::Options options;
  CLI::App app("starts of a vehicle with LiDAR alone anywhere in a recording");
  app.add_option("folder", options.folder, "compact scans with poses.tum")->required();
  app.add_option("--first", options.first_s, "first start [s]");
  app.add_option("--last", options.last_s, "last start [s]");
  app.add_option("--step", options.step_s, "between starts [s]");
  app.add_option("--duration", options.duration_s, "of the short runs [s]; 0: to the end only");
  app.add_option("--limit", options.limit_m, "a larger error is a failure [m]");
  app.add_option("--variants", options.variants, "forward, backward, half, half_backward");
  app.add_flag("--poses", options.poses, "print each pose of what failed");
  app.add_flag("--all", options.all, "print each run");
  if (const auto code = rali::bench::ended_by(app, argc, argv)) return *code;
  return rali::bench::run(options);
}
