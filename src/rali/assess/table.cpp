#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/assess/outputs.hpp"

namespace rali::assess {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::size_t kColumnsMax = 5;
constexpr std::string_view kNotKnown = "-";

struct Column {
  std::string name;
  const TrackScore* score = nullptr;
};

struct Row {
  std::string label;
  std::function<std::string(const TrackScore&)> text;
  bool always = false;  ///< also if no vehicle has a value
};

/// Enough digits for comparison: 0.0123, 1.23, 12.3.
std::string metres(double v) {
  const double size = std::abs(v);
  return size < 1.0 ? fmt::format("{:.4f}", v)
                    : (size < 100.0 ? fmt::format("{:.3f}", v) : fmt::format("{:.1f}", v));
}

std::string degrees(double rad) { return fmt::format("{:.3f}", rad / kDegree); }

std::string percent(double fraction) { return fmt::format("{:.1f}", 100.0 * fraction); }

using Statistic = double eval::Statistics::*;

Row ape(const char* label, Statistic which) {
  return {label, [which](const TrackScore& s) { return metres(s.ape_m.*which); }};
}

void add_rpe(const std::vector<double>& distances_m, std::vector<Row>& rows) {
  for (std::size_t d = 0; d < distances_m.size(); ++d) {
    rows.push_back(
        {fmt::format("RPE over {:g} m, rmse [m]", distances_m[d]), [d](const TrackScore& s) {
           const bool known = d < s.rpe.size() && s.rpe[d].translation_m.count > 0;
           return known ? metres(s.rpe[d].translation_m.rmse) : std::string(kNotKnown);
         }});
    rows.push_back({"             rmse [deg]", [d](const TrackScore& s) {
                      const bool known = d < s.rpe.size() && s.rpe[d].translation_m.count > 0;
                      return known ? degrees(s.rpe[d].rotation_rad.rmse) : std::string(kNotKnown);
                    }});
  }
}

void add_drift(std::vector<Row>& rows) {
  rows.push_back({"drift at the end [m]", [](const TrackScore& s) {
                    return s.drift ? metres(s.drift->final_m) : std::string(kNotKnown);
                  }});
  rows.push_back({"  per cent of the distance", [](const TrackScore& s) {
                    if (!s.drift || !(s.drift->path_m > 0.0)) return std::string(kNotKnown);
                    return fmt::format("{:.2f}", 100.0 * s.drift->final_m / s.drift->path_m);
                  }});
  rows.push_back({"  in height [m]",
                  [](const TrackScore& s) {
                    const bool known = s.drift && s.drift->z_m;
                    return known ? metres(*s.drift->z_m) : std::string(kNotKnown);
                  },
                  true});
}

void add_degenerate(std::vector<Row>& rows) {
  const auto degenerate = [](const TrackScore& s, auto text) {
    return s.degenerate && s.degenerate->along_m.count > 0 ? text(*s.degenerate)
                                                           : std::string(kNotKnown);
  };
  rows.push_back({"degenerate, fraction of the distance [%]", [](const TrackScore& s) {
                    return s.degenerate ? percent(s.degenerate->path_fraction)
                                        : std::string(kNotKnown);
                  }});
  rows.push_back({"  error along it, rmse [m]", [degenerate](const TrackScore& s) {
                    return degenerate(
                        s, [](const DegenerateScore& b) { return metres(b.along_m.rmse); });
                  }});
  rows.push_back({"  error across, rmse [m]", [degenerate](const TrackScore& s) {
                    return degenerate(
                        s, [](const DegenerateScore& b) { return metres(b.across_m.rmse); });
                  }});
}

void add_nees(std::vector<Row>& rows) {
  rows.push_back({"NEES, mean (honest: 6)", [](const TrackScore& s) {
                    return s.nees6 ? fmt::format("{:.2f}", s.nees6->mean) : std::string(kNotKnown);
                  }});
  rows.push_back({"  of position (3)", [](const TrackScore& s) {
                    return s.nees3 ? fmt::format("{:.2f}", s.nees3->mean) : std::string(kNotKnown);
                  }});
  rows.push_back({"  within 95 % [%] (95)", [](const TrackScore& s) {
                    return s.nees6 ? percent(s.nees6->fraction_within_95) : std::string(kNotKnown);
                  }});
}

std::vector<Row> rows_of(const EvaluationOptions& options, bool alone) {
  std::vector<Row> rows;
  rows.push_back({"poses judged", [](const TrackScore& s) { return fmt::format("{}", s.poses); }});
  rows.push_back(
      {"of the truth's time [%]", [](const TrackScore& s) { return percent(s.time_fraction); }});
  rows.push_back(
      {"distance [m]", [](const TrackScore& s) { return fmt::format("{:.1f}", s.path_m); }});
  rows.push_back(ape("APE, rmse [m]", &eval::Statistics::rmse));
  rows.push_back(ape("     mean [m]", &eval::Statistics::mean));
  rows.push_back(ape("     median [m]", &eval::Statistics::median));
  rows.push_back(ape("     max [m]", &eval::Statistics::max));
  rows.push_back(
      {"     rmse [deg]", [](const TrackScore& s) { return degrees(s.rotation_rad.rmse); }});
  if (alone) {
    rows.push_back({"     aligned alone, rmse [m]", [](const TrackScore& s) {
                      return s.alone_rmse_m ? metres(*s.alone_rmse_m) : std::string(kNotKnown);
                    }});
  }
  add_rpe(options.distances_m, rows);
  add_drift(rows);
  add_degenerate(rows);
  add_nees(rows);
  return rows;
}

/// Rows without a figure for any vehicle are omitted, unless the absence is a result.
std::string block(const std::string& title, const std::vector<Column>& columns,
                  const std::vector<Row>& rows) {
  std::string text = fmt::format("{:<30}", title);
  for (const Column& column : columns) text += fmt::format("{:>10.10}", column.name);
  text += '\n';
  for (const Row& row : rows) {
    std::string line = fmt::format("{:<30}", row.label);
    bool known = row.always;
    for (const Column& column : columns) {
      const std::string cell = row.text(*column.score);
      known = known || cell != kNotKnown;
      line += fmt::format("{:>10}", cell);
    }
    if (known) text += line + '\n';
  }
  return text;
}

std::string tracks(const std::string& title, const std::vector<Column>& columns,
                   const std::vector<Row>& rows) {
  std::string text;
  for (std::size_t i = 0; i < columns.size(); i += kColumnsMax) {
    const std::size_t end = std::min(i + kColumnsMax, columns.size());
    text += '\n';
    text += block(title,
                  {columns.begin() + static_cast<std::ptrdiff_t>(i),
                   columns.begin() + static_cast<std::ptrdiff_t>(end)},
                  rows);
  }
  return text;
}

bool same_figures(const TrackScore& a, const TrackScore& b) {
  constexpr double kSame_m = 5e-6;
  const auto same = [](const eval::Statistics& x, const eval::Statistics& y) {
    return x.count == y.count && std::abs(x.rmse - y.rmse) < kSame_m &&
           std::abs(x.max - y.max) < kSame_m;
  };
  if (!same(a.ape_m, b.ape_m) || a.rpe.size() != b.rpe.size()) return false;
  for (std::size_t d = 0; d < a.rpe.size(); ++d) {
    if (!same(a.rpe[d].translation_m, b.rpe[d].translation_m)) return false;
  }
  return true;
}

/// Whether nothing has corrected the odometry: its figures then equal those of the trajectory.
bool odometry_is_final(const Evaluation& e) {
  return std::all_of(e.vehicles.begin(), e.vehicles.end(), [](const VehicleScore& v) {
    return !v.odometry || same_figures(v.trajectory, *v.odometry);
  });
}

std::string mesh_lines(const char* title, const eval::CloudToMesh& c) {
  return fmt::format(
      "{:<30}mean {} std {} 95 % {} max {} m\n"
      "{:<30}{} of {} points beyond 1 m left out ({:.2f} %)\n"
      "{:<30}{:.1f} % of the mesh has a point within 0.1 m\n",
      title, metres(c.within.mean), metres(c.within.std), metres(c.p95_m), metres(c.within.max), "",
      c.beyond, c.all.count, 100.0 * c.fraction_beyond, "  completeness", 100.0 * c.completeness);
}

std::string cloud_text(const CloudScore& c, const std::string& mesh) {
  std::string text = fmt::format("\nmap {}, {} points\n", c.file, c.points);
  if (c.to_mesh) text += fmt::format("against {}, one point per 5 cm\n", mesh);
  if (c.before_icp) text += mesh_lines("distance to mesh, as aligned", *c.before_icp);
  if (c.icp) {
    text +=
        fmt::format("{:<30}rmse of the nearest 90 % {} -> {} m, {} steps{}{}\n",
                    "laid onto the mesh (ICP)", metres(c.icp->rmse_start_m), metres(c.icp->rmse_m),
                    c.icp->iterations, c.icp->converged ? "" : ", not converged",
                    c.icp->open_directions > 0
                        ? fmt::format(", {} of 6 directions left open", c.icp->open_directions)
                        : "");
  }
  if (c.to_mesh) {
    text += mesh_lines(c.icp ? "distance to mesh, after ICP" : "distance to mesh", *c.to_mesh);
  }
  if (c.shape.patches > 0) {
    text += fmt::format("{:<30}median {} mean {} 95 % {} m\n", "thickness of walls",
                        metres(c.shape.thickness.median), metres(c.shape.thickness.mean),
                        metres(c.shape.thickness_p95_m));
  }
  if (c.shape.mme)
    text += fmt::format("{:<30}{:.3f} (radius 0.3 m)\n", "mean map entropy", *c.shape.mme);
  return text;
}

}  // namespace

std::string evaluation_table(const Evaluation& e) {
  std::string text = e.input;
  if (!e.truth.empty()) text += " against " + e.truth;
  text += '\n';
  if (!e.vehicles.empty()) text += e.how() + '\n';
  std::vector<Column> final_poses, live, odometry;
  for (const VehicleScore& v : e.vehicles) {
    final_poses.push_back({v.name, &v.trajectory});
    if (v.live) live.push_back({v.name, &*v.live});
    if (v.odometry) odometry.push_back({v.name, &*v.odometry});
  }
  const bool fleet = e.vehicles.size() > 1;
  if (fleet) final_poses.push_back({"all", &e.fleet});
  if (fleet && e.fleet_live) live.push_back({"all", &*e.fleet_live});
  if (fleet && e.fleet_odometry) odometry.push_back({"all", &*e.fleet_odometry});
  if (!final_poses.empty()) {
    text += tracks(odometry.empty() && live.empty() ? "" : "trajectory (final)", final_poses,
                   rows_of(e.options, fleet && !e.options.each));
  }
  if (!live.empty()) text += tracks("live (in map, at the time)", live, rows_of(e.options, false));
  if (!odometry.empty() && odometry_is_final(e)) {
    text += "\nodometry (as processed): the same, nothing has corrected it\n";
  } else if (!odometry.empty()) {
    text += tracks("odometry (as processed)", odometry, rows_of(e.options, false));
  }
  if (!e.between.empty())
    text += "\nbetween vehicles, no alignment      rmse [m]   max [m]  rmse [deg]\n";
  for (const PairScore& pair : e.between) {
    text += fmt::format("{:<34}{:>10}{:>10}{:>12}\n", pair.a + " - " + pair.b,
                        metres(pair.translation_m.rmse), metres(pair.translation_m.max),
                        degrees(pair.rotation_rad.rmse));
  }
  if (e.cloud) text += cloud_text(*e.cloud, e.mesh);
  return text;
}

}  // namespace rali::assess
