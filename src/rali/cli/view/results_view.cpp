#include "rali/cli/view/results_view.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::cli {
namespace {

using nlohmann::json;

constexpr std::size_t kStatesMax = 600, kPathPointsMax = 5000, kCloudPointsMax = 1'000'000;
constexpr double kNear_s = 2.0;  ///< older poses, covariances and degeneracies are not shown

json place(const geometry::Vec3& p_m) { return {p_m.x(), p_m.y(), p_m.z()}; }

/// The last entry not after t_s, if it is recent enough.
template <class T>
const T* entry_at(const std::vector<T>& list, double t_s) {
  const auto after = std::upper_bound(list.begin(), list.end(), t_s,
                                      [](double t, const T& entry) { return t < entry.t_s; });
  if (after == list.begin()) return nullptr;
  return t_s - std::prev(after)->t_s <= kNear_s ? &*std::prev(after) : nullptr;
}

/// 1 sigma in the plane; half axes are the roots of the eigenvalues.
json ellipse_of(const report::SigmaPoint& point) {
  const double xx = point.cov_m2[0], xy = point.cov_m2[1], yy = point.cov_m2[3];
  const double mean = 0.5 * (xx + yy), half = std::hypot(0.5 * (xx - yy), xy);
  if (!std::isfinite(mean + half) || mean + half <= 0.0) return nullptr;
  return {{"major_m", std::sqrt(mean + half)},
          {"minor_m", std::sqrt(std::max(mean - half, 0.0))},
          {"angle_rad", 0.5 * std::atan2(2.0 * xy, xx - yy)}};
}

const report::Round* round_at(const report::RunData& run, double t_s) {
  for (const report::Round& round : run.rounds) {
    if (t_s >= round.start_s && !(t_s >= round.end_s)) return &round;
  }
  return nullptr;
}

/// Direction of motion around a row of a trajectory.
void add_motion(const std::vector<report::PathPoint>& path, std::size_t row, json& vehicle) {
  constexpr std::size_t kReach = 5;
  const report::PathPoint& a = path[row < kReach ? 0 : row - kReach];
  const report::PathPoint& b = path[std::min(row + kReach, path.size() - 1)];
  const geometry::Vec3 step = b.p_m - a.p_m;
  const double speed_mps = b.t_s > a.t_s ? step.norm() / (b.t_s - a.t_s) : 0.0;
  vehicle["speed_mps"] = speed_mps;
  vehicle["at_rest"] = speed_mps < 0.05;
  if (std::hypot(step.x(), step.y()) > 0.05) vehicle["yaw_rad"] = std::atan2(step.y(), step.x());
}

json vehicle_at(const report::VehicleView& v, double t_s, const report::Round* round) {
  json out = {{"name", v.name}};
  if (round != nullptr) out["role"] = round->anchor == v.name ? "anchor" : "tag";
  if (!v.in_map) {
    out["frame"] = "local";
    out["waits_for"] = v.name + " was not joined to the map.";
    return out;
  }
  const report::PathPoint* pose = entry_at(v.path, t_s);
  if (pose == nullptr) {
    if (v.path.empty() || t_s < v.path.front().t_s) return out;
    pose = &*std::prev(
        std::upper_bound(v.path.begin(), v.path.end(), t_s,
                         [](double t, const report::PathPoint& entry) { return t < entry.t_s; }));
    out["age_s"] = t_s - pose->t_s;
  }
  out["position_m"] = place(pose->p_m);
  add_motion(v.path, static_cast<std::size_t>(pose - v.path.data()), out);
  if (const report::SigmaPoint* sigma = entry_at(v.sigmas, t_s)) {
    json ellipse = ellipse_of(*sigma);
    if (!ellipse.is_null()) out["ellipse"] = std::move(ellipse);
  }
  const report::DegeneracyPoint* degeneracy = entry_at(v.degeneracy, t_s);
  if (degeneracy != nullptr && degeneracy->degenerate && degeneracy->axis.allFinite()) {
    out["degenerate"] = {{"axis", place(degeneracy->axis)}};
  }
  return out;
}

json frontiers_of(const report::RunData& run, const report::Round& round) {
  json out = json::array();
  for (const report::Frontier& f : run.frontiers) {
    if (f.round != round.round || !std::isfinite(f.p_m.x() + f.p_m.y())) continue;
    const double z_m = std::isfinite(f.p_m.z()) ? f.p_m.z() : 0.0;
    json frontier = {{"position_m", {f.p_m.x(), f.p_m.y(), z_m}}};
    if (std::isfinite(f.length_m)) frontier["size_m"] = f.length_m;
    out.push_back(std::move(frontier));
  }
  return out;
}

double driven_m(const report::RunData& run, double t_s) {
  double sum = 0.0;
  for (const report::VehicleView& v : run.vehicles) {
    for (std::size_t i = 1; i < v.path.size() && v.path[i].t_s <= t_s; ++i) {
      sum += (v.path[i].p_m - v.path[i - 1].p_m).norm();
    }
  }
  return sum;
}

json state_at(const report::RunData& run, double t_s, double distance_m) {
  const report::Round* round = round_at(run, t_s);
  json vehicles = json::array(), diagnostics = json::array();
  for (const report::VehicleView& v : run.vehicles) vehicles.push_back(vehicle_at(v, t_s, round));
  for (const report::Warning& warning : run.warnings) {
    json line = {{"level", "warn"}, {"name", warning.id}, {"message", warning.text}};
    if (!warning.vehicle.empty()) line["vehicle"] = warning.vehicle;
    diagnostics.push_back(std::move(line));
  }
  json out = {{"schema", 1},
              {"t_s", t_s},
              {"vehicle", run.name},
              {"frame", "map"},
              {"mission", {{"distance_m", distance_m}}},
              {"vehicles", std::move(vehicles)},
              {"diagnostics", std::move(diagnostics)}};
  if (round == nullptr) return out;
  out["mission"]["state"] = fmt::format("Round {}: {} stands.", round->round, round->anchor);
  out["anchor"] = {{"vehicle", round->anchor}};
  out["frontiers"] = frontiers_of(run, *round);
  return out;
}

struct Span {
  double start_s = 0.0, end_s = 0.0;
  bool known = false;
};

Span span_of(const report::RunData& run) {
  Span span;
  for (const report::VehicleView& v : run.vehicles) {
    if (v.path.empty()) continue;
    const double begin = v.path.front().t_s, end = v.path.back().t_s;
    span.start_s = span.known ? std::min(span.start_s, begin) : begin;
    span.end_s = span.known ? std::max(span.end_s, end) : end;
    span.known = true;
  }
  return span;
}

std::string text_of(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

std::string results_state(const report::RunData& run) {
  const double end_s = span_of(run).end_s;
  return text_of(state_at(run, end_s, driven_m(run, end_s)));
}

std::string results_history(const report::RunData& run) {
  const Span span = span_of(run);
  const double length_s = span.end_s - span.start_s;
  const auto states = static_cast<std::size_t>(
      std::clamp(std::ceil(length_s), 1.0, static_cast<double>(kStatesMax - 1)));
  json list = json::array();
  for (std::size_t i = 0; i <= states; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(states);
    const double t_s = i == states ? span.end_s : span.start_s + part * length_s;
    list.push_back(state_at(run, t_s, driven_m(run, t_s)));
  }
  return text_of({{"states", std::move(list)}});
}

std::string results_paths(const report::RunData& run) {
  json paths = json::array();
  for (const report::VehicleView& v : run.vehicles) {
    if (!v.in_map || v.path.empty()) continue;
    json times = json::array(), positions = json::array(), degenerate = json::array();
    const std::size_t step = (v.path.size() - 1) / kPathPointsMax + 1;
    for (std::size_t i = 0; i < v.path.size(); i += step) {
      const report::DegeneracyPoint* point = entry_at(v.degeneracy, v.path[i].t_s);
      times.push_back(v.path[i].t_s);
      positions.push_back(place(v.path[i].p_m));
      degenerate.push_back(point != nullptr && point->degenerate ? 1 : 0);
    }
    paths.push_back({{"vehicle", v.name},
                     {"t_s", std::move(times)},
                     {"position_m", std::move(positions)},
                     {"degenerate", std::move(degenerate)}});
  }
  return text_of({{"t_s", span_of(run).end_s}, {"paths", std::move(paths)}});
}

wire::Bytes results_cloud(const report::RunData& run, const std::vector<float>& seen_s) {
  constexpr float kAlways_s = 1e6F;  // no keyframe has the point: it is shown at all times
  const report::MapPoints& map = run.map;
  const bool timed = seen_s.size() == map.size();
  const std::uint32_t step = timed ? 17 : 13;
  const std::size_t every = map.size() / kCloudPointsMax + 1;
  const double end_s = span_of(run).end_s;
  wire::Bytes data;
  data.reserve(step * (map.size() / every + 1));
  const auto put = [&](float value) {
    const auto* raw = reinterpret_cast<const std::byte*>(&value);
    data.insert(data.end(), raw, raw + sizeof value);
  };
  for (std::size_t i = 0; i < map.size(); i += every) {
    for (const float value : {map.x_m[i], map.y_m[i], map.z_m[i]}) put(value);
    data.push_back(static_cast<std::byte>(i < map.vehicle.size() ? map.vehicle[i] : 0));
    if (!timed) continue;
    const bool known = std::isfinite(seen_s[i]);
    put(known ? static_cast<float>(end_s - double{seen_s[i]}) : kAlways_s);
  }
  wire::CloudView cloud;
  cloud.stamp = Time::from_s(end_s);
  cloud.frame_id = "map";
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(data.size() / step);
  cloud.point_step = step;
  cloud.row_step = step * cloud.width;
  cloud.fields = {{"x", 0, wire::FieldType::kFloat32},
                  {"y", 4, wire::FieldType::kFloat32},
                  {"z", 8, wire::FieldType::kFloat32},
                  {"vehicle", 12, wire::FieldType::kUint8}};
  if (timed) cloud.fields.push_back({"age_s", 13, wire::FieldType::kFloat32});
  cloud.data = data;
  return wire::encode(cloud, wire::Encoding::kCdr);
}

void publish_results(const report::RunData& run, const std::vector<float>& seen_s,
                     view::ViewServer& server) {
  const Time t = Time::from_s(span_of(run).end_s);
  const auto publish = [&](int channel, std::span<const std::byte> bytes) {
    server.publish(channel, t, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  };
  const auto publish_json = [&](const char* topic, const char* schema, const std::string& text) {
    const int channel =
        server.add_channel({topic, "json", schema, "jsonschema", R"({"type":"object"})", true});
    publish(channel, std::as_bytes(std::span(text)));
  };
  publish_json("/rali/paths", "rali/Paths", results_paths(run));
  publish_json("/rali/history", "rali/History", results_history(run));
  publish_json("/rali/state", "rali/State", results_state(run));
  if (run.map.size() > 0) {
    const std::string type = "sensor_msgs/msg/PointCloud2";
    publish(server.add_channel({"/map_cloud", "cdr", type, "ros2msg",
                                wire::message_definition(type, wire::Encoding::kCdr), true}),
            results_cloud(run, seen_s));
  }
  server.set_health(true, R"({"state":"finished results"})");
}

}  // namespace rali::cli
