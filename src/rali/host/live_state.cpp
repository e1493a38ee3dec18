#include "rali/host/live_state.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace rali::host {
namespace {

using nlohmann::json;

constexpr std::size_t kPathMax = 5000;
constexpr std::string_view kLevels[] = {"ok", "warn", "error", "stale"};

/// Millimetres are sufficient, and shorter.
double rounded(double value) { return std::round(value * 1e3) / 1e3; }

json point(const geometry::Vec3& p) {
  return json::array({rounded(p.x()), rounded(p.y()), rounded(p.z())});
}

void put_known(json& out, const char* key, const std::optional<double>& value) {
  if (value && std::isfinite(*value)) out[key] = *value;
}

void put_text(json& out, const char* key, const std::string& text) {
  if (!text.empty()) out[key] = text;
}

json vehicle_json(const StateVehicle& v) {
  json out{{"name", v.name}, {"at_rest", v.at_rest}};
  put_known(out, "age_s", v.age_s);
  put_text(out, "role", v.role);
  put_text(out, "mode", v.mode);
  put_text(out, "waits_for", v.waits_for);
  put_known(out, "battery", v.battery);
  put_known(out, "speed_mps", v.speed_mps);
  put_known(out, "sigma_z_m", v.sigma_z_m);
  if (v.position_m) {
    out["position_m"] = point(*v.position_m);
    out["yaw_rad"] = rounded(v.yaw_rad);
    out["frame"] = v.frame;
  }
  if (v.ellipse) {
    out["ellipse"] = {{"major_m", v.ellipse->major_m},
                      {"minor_m", v.ellipse->minor_m},
                      {"angle_rad", v.ellipse->angle_rad}};
  }
  if (v.degenerate_axis) {
    out["degenerate"] = {{"axis", point(*v.degenerate_axis)}, {"since_s", v.degenerate_since_s}};
  }
  return out;
}

json link_json(const StateLink& l) {
  json out{{"from", l.from},       {"to", l.to},         {"connected", l.connected},
           {"refused", l.refused}, {"forged", l.forged}, {"repeated", l.repeated}};
  put_known(out, "rate_Bps", l.rate_Bps);
  put_known(out, "age_s", l.age_s);
  put_known(out, "rssi_dbm", l.rssi_dbm);
  return out;
}

json anchor_json(const StateAnchor& a) {
  json out{{"vehicle", a.vehicle}, {"since_s", rounded(a.since_s)}};
  if (!a.lost) return out;
  json lost{{"vehicle", a.lost->vehicle},
            {"age_s", rounded(a.lost->age_s)},
            {"message", a.lost->message},
            {"command", a.lost->command}};
  if (a.lost->position_m) lost["position_m"] = point(*a.lost->position_m);
  out["lost"] = std::move(lost);
  return out;
}

json range_json(const StateRange& r) {
  json out{{"from", r.from},
           {"to", r.to},
           {"range_m", rounded(r.range_m)},
           {"used", r.used},
           {"age_s", rounded(r.age_s)}};
  put_text(out, "reason", r.reason);
  return out;
}

json diagnostic_json(const DiagnosticLine& d) {
  json out{{"level", kLevels[static_cast<std::size_t>(d.level)]},
           {"name", d.name},
           {"message", d.message}};
  put_text(out, "remedy", d.remedy);
  put_known(out, "age_s", d.age_s);
  return out;
}

json sensor_json(const StateSensor& s) {
  json out{
      {"name", s.name}, {"topic", s.topic}, {"rate_hz", rounded(s.rate_hz)}, {"drops", s.drops}};
  put_known(out, "age_s", s.age_s);
  return out;
}

/// Text from drivers and other vehicles may not be UTF-8.
std::string text_of_json(const json& document) {
  return document.dump(-1, ' ', false, json::error_handler_t::replace);
}

template <class T, class F>
json list_of(const std::vector<T>& values, F make) {
  json list = json::array();
  for (const T& value : values) list.push_back(make(value));
  return list;
}

}  // namespace

std::string state_json(const LiveState& s) {
  json out{
      {"schema", 1},      {"t_s", s.t_s},   {"vehicle", s.vehicle}, {"epoch", s.epoch},
      {"frame", s.frame}, {"term", s.term}, {"mode", s.mode},       {"waits_for", s.waits_for}};
  out["mission"] = {{"round", s.round},
                    {"state", s.mission},
                    {"distance_m", rounded(s.distance_m)},
                    {"finished", s.finished}};
  if (s.anchor) out["anchor"] = anchor_json(*s.anchor);
  out["vehicles"] = list_of(s.vehicles, vehicle_json);
  out["links"] = list_of(s.links, link_json);
  out["ranges"] = list_of(s.ranges, range_json);
  out["frontiers"] = list_of(s.frontiers, [](const StateFrontier& f) {
    return json{{"position_m", point(f.position_m)}, {"size_m", rounded(f.size_m)}};
  });
  out["goals"] = list_of(s.goals, [](const StateGoal& g) {
    return json{{"vehicle", g.vehicle},
                {"position_m", point(g.path_m.back())},
                {"path_m", list_of(g.path_m, point)}};
  });
  out["diagnostics"] = list_of(s.diagnostics, diagnostic_json);
  out["sensors"] = list_of(s.sensors, sensor_json);
  if (s.table) {
    out["table"] = {{"term", s.table->term},
                    {"revision", s.table->revision},
                    {"poses", s.table->poses},
                    {"moved_poses", s.table->moved_poses},
                    {"moved_max_m", rounded(s.table->moved_max_m)}};
    put_text(out["table"], "moved_vehicle", s.table->moved_vehicle);
  }
  if (s.disk) {
    out["disk"] = {
        {"free_bytes", s.disk->free_bytes}, {"state", s.disk->state}, {"message", s.disk->message}};
  }
  out["steps"] = {{"p50_s", s.step_p50_s},
                  {"p99_s", s.step_p99_s},
                  {"max_s", s.step_max_s},
                  {"queue", s.queue},
                  {"queue_max", s.queue_max}};
  out["odometry"] = {{"latency_p50_s", s.latency_p50_s}, {"latency_p99_s", s.latency_p99_s}};
  return text_of_json(out);
}

std::string paths_json(double t_s, const std::vector<StatePath>& paths) {
  json list = json::array();
  for (const StatePath& path : paths) {
    const std::size_t step = path.t_s.size() / kPathMax + 1;
    json t = json::array(), p = json::array(), d = json::array();
    for (std::size_t i = 0; i < path.t_s.size(); i += step) {
      t.push_back(rounded(path.t_s[i]));
      p.push_back(point(path.position_m[i]));
      d.push_back(path.degenerate[i] ? 1 : 0);
    }
    list.push_back({{"vehicle", path.vehicle},
                    {"t_s", std::move(t)},
                    {"position_m", std::move(p)},
                    {"degenerate", std::move(d)}});
  }
  return text_of_json(json{{"t_s", t_s}, {"paths", std::move(list)}});
}

bool health_json(const LiveState& s, std::string& text) {
  const bool bad = std::any_of(s.diagnostics.begin(), s.diagnostics.end(), [](const auto& line) {
    return line.level == DiagnosticLevel::kError || line.level == DiagnosticLevel::kStale;
  });
  json out{{"healthy", !bad},
           {"vehicle", s.vehicle},
           {"mode", s.mode},
           {"term", s.term},
           {"waits_for", s.waits_for}};
  out["sensors"] = list_of(s.sensors, sensor_json);
  out["diagnostics"] = list_of(s.diagnostics, diagnostic_json);
  text = text_of_json(out);
  return !bad;
}

std::string metrics_text(const LiveState& s) {
  std::string text;
  const auto put = [&](std::string_view name, const std::string& labels, double value) {
    text += fmt::format("rali_{}{{vehicle=\"{}\"{}{}}} {}\n", name, s.vehicle,
                        labels.empty() ? "" : ",", labels, value);
  };
  put("step_seconds", "quantile=\"0.5\"", s.step_p50_s);
  put("step_seconds", "quantile=\"0.99\"", s.step_p99_s);
  put("step_seconds_max", "", s.step_max_s);
  put("odometry_latency_seconds", "quantile=\"0.5\"", s.latency_p50_s);
  put("odometry_latency_seconds", "quantile=\"0.99\"", s.latency_p99_s);
  put("queue", "", static_cast<double>(s.queue));
  put("queue_max", "", static_cast<double>(s.queue_max));
  put("term", "", static_cast<double>(s.term));
  put("epoch", "", static_cast<double>(s.epoch));
  put("distance_meters", "", s.distance_m);
  for (const StateSensor& sensor : s.sensors) {
    const std::string labels = fmt::format("sensor=\"{}\"", sensor.name);
    put("sensor_rate_hertz", labels, sensor.rate_hz);
    put("sensor_dropped_total", labels, static_cast<double>(sensor.drops));
    if (sensor.age_s) put("sensor_age_seconds", labels, *sensor.age_s);
  }
  for (const StateLink& link : s.links) {
    const std::string labels = fmt::format("from=\"{}\",to=\"{}\"", link.from, link.to);
    put("link_connected", labels, link.connected ? 1.0 : 0.0);
    put("link_refused_total", labels, static_cast<double>(link.refused));
    put("link_forged_total", labels, static_cast<double>(link.forged));
    put("link_repeated_total", labels, static_cast<double>(link.repeated));
    if (link.rate_Bps) put("link_bytes_per_second", labels, *link.rate_Bps);
  }
  if (s.disk) put("disk_free_bytes", "", static_cast<double>(s.disk->free_bytes));
  return text;
}

}  // namespace rali::host
