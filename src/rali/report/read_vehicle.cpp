#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/text.hpp"
#include "rali/io/files/tum.hpp"
#include "rali/report/internal/read_parts.hpp"
#include "rali/report/internal/table_rows.hpp"

namespace rali::report {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kVehiclesMax = 64;

/// A name from a file must not refer to other folders.
bool is_file_name(const std::string& name) {
  return !name.empty() && name.find('/') == std::string::npos && !name.starts_with('.');
}

std::vector<PathPoint> read_path(const std::string& dir, const std::string& name, Time& t_start,
                                 RunData& run) {
  std::vector<PathPoint> points;
  const std::string path = dir + '/' + name;
  if (!file_exists(path)) return points;
  const Result<io::TumFile> tum = io::read_tum(path);
  if (!tum) {
    run.unreadable.push_back(fmt::format("{}: {}", name, tum.error().what));
    return points;
  }
  if (t_start.ns == 0 && !tum->poses.empty()) t_start = tum->poses.front().t;
  for (const io::StampedPose& pose : tum->poses) {
    if (!pose.T.p.allFinite()) continue;
    points.push_back({seconds_between(t_start, pose.t), pose.T.p});
  }
  return points;
}

void read_sigmas(const std::string& dir, Time t_start, VehicleView& v, RunData& run) {
  read_table(dir, "trajectory/" + v.name + ".cov.csv", run, [&](const TableRow& row) {
    SigmaPoint p;
    constexpr std::array<const char*, 6> kNames = {"c00", "c01", "c02", "c11", "c12", "c22"};
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      p.cov_m2[i] = static_cast<float>(row.number(kNames[i]));
    }
    const double variance = row.number("c00") + row.number("c11") + row.number("c22");
    p.t_s = row.seconds("stamp_s", t_start);
    p.sigma_m = std::sqrt(variance);
    if (std::isfinite(p.sigma_m) && std::isfinite(p.t_s)) v.sigmas.push_back(p);
  });
}

void read_errors(const std::string& dir, Time t_start, VehicleView& v, RunData& run) {
  read_table(dir, "errors/" + v.name + ".csv", run, [&](const TableRow& row) {
    ErrorPoint e;
    e.t_s = row.seconds("stamp_s", t_start);
    e.ape_m = row.number("ape_m");
    e.rot_deg = row.number("rot_deg");
    e.e_m = {row.number("ex"), row.number("ey"), row.number("ez")};
    e.along_degenerate_m = row.number("along_degenerate_m");
    e.nees = row.number("nees");
    if (std::isfinite(e.t_s)) v.errors.push_back(e);
  });
}

/// The ground truth at the evaluated poses, transformed to map: estimate minus error.
void find_truth(const RunData& run, VehicleView& v) {
  for (const TruthFrame& frame : run.truth_frames) {
    const auto& names = frame.vehicles;
    if (std::find(names.begin(), names.end(), v.name) == names.end()) continue;
    std::size_t at = 0;
    for (const ErrorPoint& e : v.errors) {
      while (at < v.path.size() && v.path[at].t_s < e.t_s - 1e-4) ++at;
      if (at == v.path.size()) break;
      if (v.path[at].t_s > e.t_s + 1e-4 || !e.e_m.allFinite()) continue;
      v.truth.push_back({e.t_s, v.path[at].p_m - frame.R_truth_map.transpose() * e.e_m});
    }
  }
}

}  // namespace

double SigmaPoint::along_m(const geometry::Vec3& a) const {
  const auto c = [&](std::size_t i) { return static_cast<double>(cov_m2[i]); };
  const double variance =
      c(0) * a.x() * a.x() + c(3) * a.y() * a.y() + c(5) * a.z() * a.z() +
      2.0 * (c(1) * a.x() * a.y() + c(2) * a.x() * a.z() + c(4) * a.y() * a.z());
  return variance >= 0.0 ? std::sqrt(variance) : kUnknown;
}

void add_vehicles_of_files(const std::string& dir, RunData& run) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(dir + "/trajectory", error)) {
    std::string name = entry.path().filename().string();
    if (!name.ends_with(".tum") || name.ends_with(".imu.tum") || name.starts_with('.')) continue;
    name.resize(name.size() - 4);
    const bool known = std::any_of(run.vehicles.begin(), run.vehicles.end(),
                                   [&](const VehicleView& v) { return v.name == name; });
    if (!known) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end(), io::natural_less);
  for (std::string& name : names) {
    if (run.vehicles.size() >= kVehiclesMax) break;
    VehicleView view;
    view.name = std::move(name);
    run.vehicles.push_back(std::move(view));
  }
}

void read_vehicle(const std::string& dir, Time& t_start, VehicleView& vehicle, RunData& run) {
  if (!is_file_name(vehicle.name)) {
    run.unreadable.push_back(
        fmt::format("metrics.json: '{}' is no name of a vehicle", io::quoted(vehicle.name)));
    return;
  }
  vehicle.path = read_path(dir, "trajectory/" + vehicle.name + ".tum", t_start, run);
  vehicle.odometry = read_path(dir, "odometry/" + vehicle.name + ".tum", t_start, run);
  read_sigmas(dir, t_start, vehicle, run);
  read_degenerate(dir, t_start, vehicle, run);
  read_errors(dir, t_start, vehicle, run);
  find_truth(run, vehicle);
}

}  // namespace rali::report
