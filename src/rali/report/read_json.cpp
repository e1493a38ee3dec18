#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "rali/io/files/input_file.hpp"
#include "rali/io/files/old_names.hpp"
#include "rali/report/internal/read_parts.hpp"

namespace rali::report {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kJsonBytesMax = 64ULL << 20;
/// Larger counts indicate a damaged file; the page would be unreadable as well.
constexpr std::size_t kVehiclesMax = 64, kWarningsMax = 500, kMeasuredMax = 5000;

/// The document, null if the file is absent or damaged.
Json read_json(const std::string& dir, const char* name, RunData& run) {
  const std::string path = dir + '/' + name;
  if (!file_exists(path)) return nullptr;
  const Result<std::vector<std::byte>> bytes = io::read_file(path, kJsonBytesMax);
  if (!bytes) {
    run.unreadable.push_back(fmt::format("{}: {}", name, bytes.error().what));
    return nullptr;
  }
  Json json = Json::parse(io::as_text(*bytes), nullptr, false);
  if (json.is_object()) return json;
  run.unreadable.push_back(fmt::format("{}: no JSON object", name));
  return nullptr;
}

const Json& at(const Json& json, const char* key) {
  static const Json kNothing;
  if (!json.is_object()) return kNothing;
  auto found = json.find(key);
  if (found == json.end()) found = json.find(std::string(io::old_name_of(key)));
  return found == json.end() ? kNothing : *found;
}

Number number(const Json& json) {
  if (!json.is_number()) return {};
  const double value = json.get<double>();
  return std::isfinite(value) ? Number(value) : Number();
}

Number number(const Json& json, const char* key) { return number(at(json, key)); }

std::string text(const Json& json) { return json.is_string() ? json.get<std::string>() : ""; }

NamedNumbers numbers(const Json& json) {
  NamedNumbers list;
  if (!json.is_object()) return list;
  for (const auto& [key, value] : json.items()) {
    if (const Number n = number(value)) list.emplace_back(key, *n);
  }
  return list;
}

VehicleNumbers vehicle_numbers(const Json& v) {
  VehicleNumbers n;
  n.path_m = number(v, "path_m");
  n.scans = number(v, "scans");
  n.scans_dropped = number(v, "scans_dropped");
  n.keyframes = number(v, "keyframes");
  n.degenerate_fraction = number(v, "degenerate_fraction");
  n.degenerate_held_fraction = number(v, "degenerate_constrained_fraction");
  n.sigma_median_m = number(v, "sigma_median_m");
  n.sigma_max_m = number(v, "sigma_max_m");
  n.diverged_s = number(v, "diverged_s");
  n.time_offset_s = number(v, "time_offset_s");
  n.clock_offset_s = number(v, "clock_offset_s");
  n.accel_scale = number(v, "accel_scale");
  const Json& noise = at(v, "imu_noise");
  n.accel_noise = number(noise, "accel_mps2_rthz");
  n.accel_noise_stated = number(noise, "accel_stated_mps2_rthz");
  n.gyro_noise = number(noise, "gyro_radps_rthz");
  n.gyro_noise_stated = number(noise, "gyro_stated_radps_rthz");
  n.gaps = numbers(at(v, "gaps"));
  return n;
}

void read_fleet(const Json& fleet, RunData& run) {
  run.loops_accepted = number(fleet, "loops_accepted");
  run.loops_refused = number(fleet, "loops_refused");
  run.rounds_count = number(fleet, "rounds");
  const Json& frames = at(fleet, "frames");
  if (frames.is_object()) {
    for (const auto& [name, frame] : frames.items()) {
      if (run.frames.size() >= kVehiclesMax) break;
      run.frames.push_back({name, text(at(frame, "decided_by")), text(at(frame, "waits_for")),
                            number(frame, "sigma_m"), number(frame, "sigma_rad")});
    }
  }
  const Json& groups = at(fleet, "groups");
  if (!groups.is_array()) return;
  for (const Json& group : groups) {
    std::vector<std::string> names;
    if (group.is_array()) {
      for (const Json& name : group) names.push_back(text(name));
    }
    if (run.groups.size() < kVehiclesMax) run.groups.push_back(std::move(names));
  }
}

void read_ranges(const Json& ranges, RunData& run) {
  run.ranges.total = number(ranges, "total");
  run.ranges.used = number(ranges, "used");
  run.ranges.rejected = numbers(at(ranges, "rejected"));
  const Json& pairs = at(ranges, "pairs");
  if (!pairs.is_object()) return;
  for (const auto& [name, pair] : pairs.items()) {
    run.ranges.pairs.push_back({name, number(pair, "bias_m"), number(pair, "bias_sigma_m"),
                                number(pair, "residual_std_m"), number(pair, "latency_s"),
                                number(pair, "latency_sigma_s")});
  }
}

void read_warnings(const Json& warnings, RunData& run) {
  if (!warnings.is_array()) return;
  for (const Json& w : warnings) {
    if (run.warnings.size() >= kWarningsMax) break;
    run.warnings.push_back({text(at(w, "id")), text(at(w, "vehicle")), text(at(w, "text"))});
  }
}

Time read_metrics(const Json& metrics, RunData& run) {
  if (!metrics.is_object()) return {};
  run.metrics_known = true;
  run.version = text(at(metrics, "rali"));
  if (run.status.empty()) run.status = text(at(metrics, "status"));
  const Json& vehicles = at(metrics, "vehicles");
  if (vehicles.is_object()) {
    for (const auto& [name, vehicle] : vehicles.items()) {
      if (run.vehicles.size() >= kVehiclesMax) break;
      VehicleView view;
      view.name = name;
      view.numbers = vehicle_numbers(vehicle);
      run.vehicles.push_back(std::move(view));
    }
  }
  read_fleet(at(metrics, "fleet"), run);
  read_ranges(at(metrics, "ranges"), run);
  const Json& map = at(metrics, "map");
  run.map_points = number(map, "points");
  run.map_voxel_m = number(map, "voxel_m");
  run.map_thickness_m = number(map, "thickness_m");
  const Json& checks = at(metrics, "checks");
  run.self_check = {number(checks, "keyframes"), number(checks, "keyframes_checked"),
                    number(checks, "contradictions")};
  read_warnings(at(metrics, "warnings"), run);
  const Number begin = number(metrics, "t_start_s"), end = number(metrics, "t_end_s");
  if (begin && end) run.duration_s = *end - *begin;
  return begin ? Time::from_s(*begin) : Time{};
}

/// All scalars below `json`, with their paths.
void flatten(const Json& json, const std::string& path, int depth, std::vector<Measured>& out) {
  if (out.size() >= kMeasuredMax || depth > 8) return;
  if (json.is_object() || json.is_array()) {
    std::size_t index = 0;
    for (const auto& item : json.items()) {
      const bool own_name = json.is_array() || path == "vehicles";
      const std::string key = json.is_array() ? std::to_string(index++)
                              : own_name      ? item.key()
                                              : std::string(io::current_name_of(item.key()));
      flatten(item.value(), path.empty() ? key : path + '.' + key, depth + 1, out);
    }
    return;
  }
  Measured m;
  m.key = path;
  m.value = number(json).value_or(kUnknown);
  m.text = json.is_string() ? json.get<std::string>()
                            : json.dump(-1, ' ', false, Json::error_handler_t::replace);
  out.push_back(std::move(m));
}

/// The alignments in evaluation.json; errors are in the axes of the ground truth.
void read_truth_frames(const Json& frames, RunData& run) {
  if (!frames.is_array()) return;
  for (const Json& frame : frames) {
    TruthFrame out;
    const Json& names = at(frame, "vehicles");
    const Json& quat = at(at(frame, "T_truth_est"), "quat_xyzw");
    if (!names.is_array() || !quat.is_array() || quat.size() != 4) continue;
    for (const Json& name : names) out.vehicles.push_back(text(name));
    Eigen::Quaterniond q;
    for (std::size_t i = 0; i < 4; ++i) {
      q.coeffs()[static_cast<Eigen::Index>(i)] = number(quat[i]).value_or(0.0);
    }
    if (std::abs(q.norm() - 1.0) > 0.01) continue;
    out.R_truth_map = q.normalized().toRotationMatrix();
    run.truth_frames.push_back(std::move(out));
  }
}

}  // namespace

Time read_json_files(const std::string& dir, RunData& run) {
  run.status = text(at(read_json(dir, "status.json", run), "status"));
  const Time t_start = read_metrics(read_json(dir, "metrics.json", run), run);
  const Json timing = read_json(dir, "timing.json", run);
  run.timing = {number(timing, "total_s"), number(timing, "data_s"), number(timing, "speed"),
                number(timing, "memory_max_mb"), numbers(at(timing, "stages_s"))};
  const Json evaluation = read_json(dir, "evaluation.json", run);
  if (evaluation.is_object()) flatten(evaluation, "", 0, run.evaluation);
  read_truth_frames(at(evaluation, "frames"), run);
  return t_start;
}

}  // namespace rali::report
