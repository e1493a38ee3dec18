#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "rali/eval/statistics.hpp"
#include "record.hpp"

namespace rali::campaign {

namespace {

constexpr double kGood_m = 0.1;  // alarms in runs with a smaller error are false alarms

double percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

bool alarmed(const RunRecord& r) {
  return r.score.lost || std::any_of(r.score.vehicles.begin(), r.score.vehicles.end(),
                                     [](const VehicleScore& v) { return v.pose_findings > 0; });
}

/// Largest error of any trajectory of the run.
double worst_m(const RunRecord& r) {
  double worst = 0.0;
  for (const VehicleScore& v : r.score.vehicles) {
    for (const auto* track : {&v.odometry, &v.live, &v.final}) {
      if (*track) worst = std::max(worst, (*track)->max_m);
    }
  }
  return worst;
}

/// True if no vehicle was lost and no avoidable gap occurred.
bool went_through(const RunRecord& r) {
  const bool joined = r.score.groups <= 1 || !r.score.solvable.joint;
  return r.score.error.empty() && !r.score.lost && joined;
}

struct Counts {
  std::size_t runs = 0, silent = 0, only_degenerate = 0, alone = 0, alone_through = 0, joint = 0,
              joint_through = 0;
  std::size_t good = 0, false_alarms = 0, failed = 0, solvable = 0;
  std::vector<double> nees, odometry_m, live_m, final_m;
  double cpu_s = 0.0;

  void add(const RunRecord& r) {
    const RunScore& s = r.score;
    ++runs;
    silent += s.silent.empty() ? 0 : 1;
    only_degenerate += s.silent.empty() && s.only_degenerate > 0 ? 1 : 0;
    failed += s.error.empty() ? 0 : 1;
    solvable += s.solvable.alone && s.solvable.joint ? 1 : 0;
    if (r.vehicles == 1 && s.solvable.alone) {
      ++alone;
      alone_through += went_through(r) ? 1 : 0;
    }
    if (r.vehicles > 1 && s.solvable.joint) {
      ++joint;
      joint_through += went_through(r) ? 1 : 0;
    }
    if (s.error.empty() && worst_m(r) < kGood_m) {
      ++good;
      false_alarms += alarmed(r) ? 1 : 0;
    }
    for (const VehicleScore& v : s.vehicles) {
      if (v.odometry) odometry_m.push_back(v.odometry->rmse_m);
      if (v.live) live_m.push_back(v.live->rmse_m);
      if (v.final) final_m.push_back(v.final->rmse_m);
      const auto& judged = v.live ? v.live : v.odometry;
      if (judged) nees.push_back(judged->nees_position);
    }
    cpu_s += r.cpu_simulated_s + r.cpu_mapped_s;
  }
};

std::string figures(const std::vector<double>& values) {
  if (values.empty()) return "-";
  return fmt::format("{:.3f} / {:.3f} / {:.2f}", eval::quantile(values, 0.5),
                     eval::quantile(values, 0.9), eval::quantile(values, 1.0));
}

std::string block_rows(const std::map<std::string, Counts>& blocks) {
  std::string text =
      "| block | runs | silent | only said to be blind | single through | fleets through | false "
      "alarms | failed to run | "
      "NEES per dof, median | odometry rmse m, median / 90 % / worst | live | final | CPU h |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [name, c] : blocks) {
    text += fmt::format(
        "| {} | {} | {} ({:.1f} %) | {} ({:.1f} %) | {}/{} ({:.1f} %) | {}/{} ({:.1f} %) | {}/{} "
        "({:.1f} %) | {} | "
        "{:.2f} | {} | {} | {} | {:.1f} |\n",
        name, c.runs, c.silent, percent(c.silent, c.runs), c.only_degenerate,
        percent(c.only_degenerate, c.runs), c.alone_through, c.alone,
        percent(c.alone_through, c.alone), c.joint_through, c.joint,
        percent(c.joint_through, c.joint), c.false_alarms, c.good, percent(c.false_alarms, c.good),
        c.failed, c.nees.empty() ? 0.0 : eval::quantile(c.nees, 0.5), figures(c.odometry_m),
        figures(c.live_m), figures(c.final_m), c.cpu_s / 3600.0);
  }
  return text;
}

std::string feature_rows(const std::vector<RunRecord>& records) {
  std::map<std::string, Counts> by;
  for (const RunRecord& r : records) {
    for (const std::string& feature : r.features) by[feature].add(r);
  }
  std::string text =
      "| feature | of runs % | silent % | not through % | odometry rmse m "
      "|\n|---|---|---|---|---|\n";
  for (const auto& [name, c] : by) {
    const std::size_t asked = c.alone + c.joint;
    const std::size_t through = c.alone_through + c.joint_through;
    text += fmt::format("| {} | {:.0f} | {:.1f} | {:.1f} | {} |\n", name,
                        percent(c.runs, records.size()), percent(c.silent, c.runs),
                        percent(asked - through, asked), figures(c.odometry_m));
  }
  return text;
}

std::string failure_rows(const std::vector<RunRecord>& records) {
  std::string text =
      "| seed | scene | what | stretch s | error m | stated m | said "
      "|\n|---|---|---|---|---|---|---|\n";
  for (const RunRecord& r : records) {
    std::string reported;
    for (const std::string& id : r.score.reported) reported += (reported.empty() ? "" : " ") + id;
    if (!r.score.error.empty()) {
      text += fmt::format("| {} | {} | run failed: {} | | | | |\n", r.seed, r.scene, r.score.error);
    }
    for (const SilentFailure& f : r.score.silent) {
      text += fmt::format("| {} | {} {} | silent, {} {} | {:.0f}-{:.0f} | {:.2f} | {:.3f} | {} |\n",
                          r.seed, r.scene, r.plan, f.trajectory, f.vehicle, f.start_s, f.end_s,
                          f.error_m, f.sigma_m, reported);
    }
    const bool asked = r.vehicles == 1 ? r.score.solvable.alone : r.score.solvable.joint;
    if (asked && r.score.error.empty() && !went_through(r)) {
      text += fmt::format("| {} | {} {} | {} | | {:.2f} | | {} |\n", r.seed, r.scene, r.plan,
                          r.score.lost ? "lost" : fmt::format("{} frames", r.score.groups),
                          worst_m(r), reported);
    }
    if (worst_m(r) < kGood_m && alarmed(r)) {
      text += fmt::format("| {} | {} {} | false alarm | | {:.3f} | | {} |\n", r.seed, r.scene,
                          r.plan, worst_m(r), reported);
    }
  }
  return text;
}

}  // namespace

std::string table_of(const std::vector<RunRecord>& records) {
  std::map<std::string, Counts> blocks;
  std::size_t solvable = 0;
  std::size_t simulated = 0;
  for (const RunRecord& r : records) {
    if (r.score.error == "no such case") continue;
    blocks[r.block].add(r);
    ++simulated;
    solvable += r.score.solvable.alone && r.score.solvable.joint ? 1 : 0;
  }
  return block_rows(blocks) +
         fmt::format("\nSolvable: {} of {} ({:.0f} %).\n\n", solvable, simulated,
                     percent(solvable, simulated)) +
         feature_rows(records) + '\n' + failure_rows(records);
}

}  // namespace rali::campaign
