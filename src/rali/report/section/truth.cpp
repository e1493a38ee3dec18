#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/section/checks.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

/// Numbers of one track (trajectory or odometry) of one vehicle or of the fleet.
struct TrackKey {
  std::string words, path;
};

/// Whether nothing has corrected the odometry: its numbers then equal those of the trajectory.
bool same_as_odometry(const RunData& run, const std::string& path) {
  constexpr double kSame_m = 1e-5;
  const Number a = measured(run, path + ".trajectory.ape_m.rmse");
  const Number b = measured(run, path + ".odometry.ape_m.rmse");
  return a && b && std::abs(*a - *b) < kSame_m;
}

std::vector<TrackKey> tracks_of(const RunData& run) {
  std::vector<TrackKey> keys;
  const auto add = [&](const std::string& words, const std::string& path) {
    if (measured(run, path + ".poses")) keys.push_back({words, path});
  };
  for (const VehicleView& v : run.vehicles) {
    add(escaped(v.name), "vehicles." + v.name + ".trajectory");
    add(escaped(v.name) + ", live", "vehicles." + v.name + ".live");
    if (!same_as_odometry(run, "vehicles." + v.name)) {
      add(escaped(v.name) + ", odometry alone", "vehicles." + v.name + ".odometry");
    }
  }
  if (run.vehicles.size() > 1) {
    add("<b>fleet</b>", "fleet.trajectory");
    add("fleet, live", "fleet.live");
    if (!same_as_odometry(run, "fleet")) add("fleet, odometry alone", "fleet.odometry");
  }
  return keys;
}

std::string position_table(const RunData& run, const std::vector<TrackKey>& keys) {
  Table table({"", "poses", "true distance", "APE rmse", "largest", "rotation rmse",
               "drift at the end", "in height", "along the degenerate axis, rmse", "across, rmse"});
  for (const TrackKey& key : keys) {
    const auto m = [&](const char* name) { return measured(run, key.path + name); };
    table.row({key.words, counted(m(".poses")), metres(m(".distance_m")), metres(m(".ape_m.rmse")),
               metres(m(".ape_m.max")), fixed(m(".ape_deg.rmse"), 2) + "&deg;",
               metres(m(".drift_final_m")), metres(m(".drift_z_m")),
               metres(m(".degenerate.along_m.rmse")), metres(m(".degenerate.across_m.rmse"))});
  }
  if (table.empty()) return {};
  std::string html = "<div class=\"wide\">" + table.lean_html() + "</div>";
  html +=
      "<p class=\"note\">APE: distance of each pose to the truth after the best fit of the whole "
      "path to it, so that it is not zero at the start. Drift: distance at the end if the first "
      "poses are laid onto each other.";
  const bool same = std::any_of(run.vehicles.begin(), run.vehicles.end(), [&](const auto& v) {
    return same_as_odometry(run, "vehicles." + v.name);
  });
  if (same) html += " The odometry alone has the same numbers: nothing has corrected it.";
  return html + "</p>\n";
}

/// A row per track, a column per distance.
std::string relative_table(const RunData& run, const std::vector<TrackKey>& keys) {
  constexpr int kDistancesMax = 4;
  std::vector<std::string> head = {"relative error, rmse"};
  std::vector<double> distances_m;
  for (const TrackKey& key : keys) {
    for (int i = 0; i < kDistancesMax; ++i) {
      const Number d = measured(run, fmt::format("{}.rpe.{}.distance_m", key.path, i));
      if (!d || std::find(distances_m.begin(), distances_m.end(), *d) != distances_m.end())
        continue;
      distances_m.push_back(*d);
    }
  }
  std::sort(distances_m.begin(), distances_m.end());
  for (const double d : distances_m) head.push_back("over " + metres(d));
  Table table(std::move(head));
  for (const TrackKey& key : keys) {
    std::vector<std::string> cells(1 + distances_m.size(), fixed(kUnknown, 0));
    cells[0] = key.words;
    bool any = false;
    for (int i = 0; i < kDistancesMax; ++i) {
      const std::string path = fmt::format("{}.rpe.{}", key.path, i);
      const Number d = measured(run, path + ".distance_m"), rmse = measured(run, path + ".m.rmse");
      const auto at = d ? std::find(distances_m.begin(), distances_m.end(), *d) : distances_m.end();
      if (!rmse || at == distances_m.end()) continue;
      any = true;
      cells[1 + static_cast<std::size_t>(at - distances_m.begin())] =
          fmt::format("{}, {}&deg;", metres(rmse), fixed(measured(run, path + ".deg.rmse"), 2));
    }
    if (any) table.row(std::move(cells));
  }
  return table.empty() ? "" : "<div class=\"wide\">" + table.html() + "</div>";
}

std::string consistency_table(const RunData& run, const std::vector<TrackKey>& keys) {
  Table table({"are the covariances right?", "pose: error over sigma, rms", "NEES (expected 6)",
               "within 95 % bounds", "position: error over sigma, rms", "NEES (expected 3)",
               "within 95 % bounds"});
  for (const TrackKey& key : keys) {
    std::vector<std::string> cells = {key.words};
    for (const char* kind : {".nees_pose", ".nees_position"}) {
      const auto m = [&](const char* name) { return measured(run, key.path + kind + name); };
      cells.push_back(ratio_text(m(".mean"), m(".expected_mean")));
      cells.push_back(at_most(m(".mean"), 1000.0, 2));
      cells.push_back(percent(m(".fraction_within_95")));
    }
    const auto known = [](const std::string& cell) { return cell != fixed(kUnknown, 0); };
    if (std::any_of(cells.begin() + 1, cells.end(), known)) table.row(std::move(cells));
  }
  if (table.empty()) return {};
  std::string html = "<div class=\"wide\">" + table.lean_html() +
                     "</div><p class=\"note\">NEES: squared error over the stated covariance, both "
                     "relative to the pose that fixes the map, the first one of the first vehicle";
  if (const Number fixed_poses = measured(run, "fleet.trajectory.reference_poses");
      fixed_poses && *fixed_poses > 1.0) {
    html += fmt::format(", which {} poses have not left: these have none", counted(fixed_poses));
  }
  return html +
         ". Above the expected value the covariance is too small, far below too large.</p>\n";
}

std::string cloud_html(const RunData& run) {
  const auto m = [&](const char* name) { return measured(run, fmt::format("cloud.{}", name)); };
  std::string html;
  if (m("to_mesh.mean_m")) {
    html += fmt::format(
        "<p>Map to the true surface: mean <b>{}</b>, standard deviation {}, 95 % within {}; {} of "
        "the points lie beyond {} and are left out. The map covers {} of the surface of the whole "
        "scene, rooms never entered included.</p>\n",
        metres(m("to_mesh.mean_m")), metres(m("to_mesh.std_m")), metres(m("to_mesh.p95_m")),
        percent(m("to_mesh.fraction_beyond_cut")), metres(m("to_mesh.cut_m")),
        percent(m("to_mesh.completeness")));
  }
  if (m("shape.thickness_m.median")) {
    html += fmt::format("<p>Thickness of the map's surfaces: median {}, 95 % below {}.</p>\n",
                        metres(m("shape.thickness_m.median")), metres(m("shape.thickness_p95_m")));
  }
  return html;
}

/// The alignment, in the words of the evaluation.
std::string how(const RunData& run) {
  for (const Measured& m : run.evaluation) {
    if (m.key == "how") return "<p class=\"note\">" + escaped(m.text) + "</p>\n";
  }
  return {};
}

}  // namespace

Section truth_section(const RunData& run) {
  Section section{"truth", "Against ground truth", ""};
  const bool errors = std::any_of(run.vehicles.begin(), run.vehicles.end(),
                                  [](const VehicleView& v) { return !v.errors.empty(); });
  if (!run.evaluated() && !errors) {
    section.html = absent("No truth: the run was not evaluated (rali evaluate).");
    return section;
  }
  const std::vector<TrackKey> keys = tracks_of(run);
  section.html += how(run) + position_table(run, keys);
  if (errors) section.html += "<div class=\"plots\" data-figure=\"truth\"></div>\n";
  section.html += relative_table(run, keys) + consistency_table(run, keys) + cloud_html(run);
  return section;
}

}  // namespace rali::report
