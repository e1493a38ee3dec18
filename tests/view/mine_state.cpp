#include "mine_state.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "mine.hpp"

namespace rali::view_demo {
namespace {

using nlohmann::json;

std::string name_of(int vehicle) { return fmt::format("v{}", vehicle + 1); }

bool is_lost(double t_s) { return t_s >= kLostStart_s && t_s < kLostEnd_s; }

/// Time of the last message of a vehicle: that of its loss if it is lost.
double received_at(int vehicle, double t_s) {
  return vehicle == 2 && is_lost(t_s) ? kLostStart_s - 2.0 : t_s;
}

json position(int vehicle, double t_s) {
  const Pose pose = pose_of(vehicle, t_s);
  const double error_m = vehicle == 2 ? gallery_error_m(t_s) : 0.0;
  return {pose.x_m + error_m, pose.y_m + 0.5 * error_m, 0.1};
}

/// Seconds of uninterrupted degenerate driving until now: the uncertainty along it grows.
double bare_s(int vehicle, double t_s) {
  double since = 0.0;
  for (double t = t_s; t > 0.0 && pose_of(vehicle, t).degenerate; t -= 1.0) since += 1.0;
  return since;
}

std::string waits_for(int vehicle, double t_s) {
  if (vehicle == anchor_at(t_s)) {
    return fmt::format("{} stands until the others have explored.", name_of(vehicle));
  }
  if (is_lost(t_s)) return fmt::format("{} waits for an anchor.", name_of(vehicle));
  if (pose_of(vehicle, t_s).at_rest)
    return fmt::format("{} waits for the next goal.", name_of(vehicle));
  return fmt::format("{} waits for nothing.", name_of(vehicle));
}

json vehicle_at(int vehicle, double t_s) {
  const double received_s = received_at(vehicle, t_s);
  const Pose pose = pose_of(vehicle, received_s);
  const double bare = bare_s(vehicle, received_s);
  const double major_m = 0.12 + 0.012 * bare + 0.0006 * received_s;
  json out = {{"name", name_of(vehicle)},
              {"position_m", position(vehicle, received_s)},
              {"yaw_rad", pose.yaw_rad},
              {"ellipse",
               {{"major_m", major_m},
                {"minor_m", 0.06},
                {"angle_rad", std::atan2(pose.axis[1], pose.axis[0])}}},
              {"age_s", vehicle == 0 ? 0.05 : t_s - received_s + 0.4},
              {"role", vehicle == anchor_at(t_s) ? "anchor" : "tag"},
              {"mode", vehicle == anchor_at(t_s) ? "stand"
                       : pose.at_rest            ? "wait"
                                                 : "explore"},
              {"waits_for", waits_for(vehicle, t_s)},
              {"at_rest", pose.at_rest},
              {"battery", 0.93 - 0.0009 * t_s - 0.06 * vehicle},
              {"speed_mps", pose.speed_mps}};
  if (pose.degenerate) {
    out["degenerate"] = {{"axis", {pose.axis[0], pose.axis[1], 0.0}}, {"since_s", bare}};
  }
  return out;
}

double distance_m(int a, int b, double t_s) {
  const Pose p = pose_of(a, t_s), q = pose_of(b, t_s);
  return std::hypot(p.x_m - q.x_m, p.y_m - q.y_m);
}

bool in_sight(int a, int b, double t_s) {
  const Pose p = pose_of(a, t_s), q = pose_of(b, t_s);
  return std::abs(p.y_m - q.y_m) < 3.0 || std::abs(p.x_m - q.x_m) < 2.5;
}

json links_at(double t_s) {
  json out = json::array();
  for (int a = 0; a < kVehicles; ++a) {
    for (int b = 0; b < kVehicles; ++b) {
      if (a == b) continue;
      const double d = distance_m(a, b, t_s) + (in_sight(a, b, t_s) ? 0.0 : 25.0);
      const bool connected = d < 95.0 && !(is_lost(t_s) && (a == 2 || b == 2));
      json link = {{"from", name_of(a)}, {"to", name_of(b)}, {"connected", connected}};
      if (connected) {
        link["loss"] = std::clamp(0.005 + 0.00005 * d * d + 0.01 * (a + 2 * b), 0.0, 0.9);
        link["rate_Bps"] = 900000.0 / (12.0 + d);
        link["delay_s"] = 0.004 + 0.0003 * d;
      }
      link["age_s"] = connected ? 0.4 : t_s - kLostStart_s + 2.0;
      out.push_back(link);
    }
  }
  return out;
}

json ranges_at(double t_s) {
  json out = json::array();
  for (int a = 0; a < kVehicles; ++a) {
    for (int b = a + 1; b < kVehicles; ++b) {
      if (is_lost(t_s) && b == 2) continue;
      const double d = distance_m(a, b, t_s);
      if (d > 70.0) continue;
      const bool sight = in_sight(a, b, t_s);
      const bool anchor = a == anchor_at(t_s) || b == anchor_at(t_s);
      json range = {{"from", name_of(a)},
                    {"to", name_of(b)},
                    {"range_m", d},
                    {"used", sight && anchor},
                    {"age_s", 0.1}};
      if (!sight) range["reason"] = "no line of sight";
      if (sight && !anchor) range["reason"] = "neither stands";
      out.push_back(range);
    }
  }
  return out;
}

json frontiers_at(double t_s) {
  struct Open {
    double x, y, until_s, size_m;
  };

  constexpr std::array<Open, 5> kOpen = {{{30, 14, 60, 3.4},
                                          {58, -12, 208, 3.4},
                                          {66, 0, 168, 4.0},
                                          {92, 6.5, 204, 2.0},
                                          {94, -6, 232, 2.6}}};
  json out = json::array();
  for (const Open& open : kOpen) {
    if (t_s > 20 && t_s < open.until_s) {
      out.push_back({{"position_m", {open.x, open.y, 0.0}}, {"size_m", open.size_m}});
    }
  }
  return out;
}

json goals_at(double t_s) {
  json out = json::array();
  for (int v = 0; v < kVehicles; ++v) {
    if (v == anchor_at(t_s) || pose_of(v, t_s).at_rest) continue;
    const Pose near = pose_of(v, t_s + 8.0), far = pose_of(v, t_s + 16.0);
    out.push_back(
        {{"vehicle", name_of(v)},
         {"position_m", {far.x_m, far.y_m, 0.0}},
         {"path_m", {position(v, t_s), {near.x_m, near.y_m, 0.0}, {far.x_m, far.y_m, 0.0}}}});
  }
  return out;
}

json stretches_at(double t_s) {
  json out = json::array();
  for (int v = 0; v < kVehicles; ++v) {
    json path = json::array();
    const auto end = [&] {
      if (path.size() > 2)
        out.push_back({{"vehicle", name_of(v)}, {"path_m", path}, {"corrected", true}});
      path = json::array();
    };
    for (double t = 0.0; t <= received_at(v, t_s); t += 2.0) {
      if (pose_of(v, t).degenerate)
        path.push_back(position(v, t));
      else
        end();
    }
    end();
  }
  return out;
}

json diagnostics_at(double t_s) {
  json out = {{{"level", "ok"}, {"name", "lidar"}, {"message", "10.0 scans per second."}},
              {{"level", "ok"}, {"name", "imu"}, {"message", "400 samples per second."}},
              {{"level", "ok"}, {"name", "disk"}, {"message", "41 GB are free."}}};
  if (t_s > 70 && t_s < 120) {
    out.push_back(
        {{"level", "warn"},
         {"name", "uwb"},
         {"vehicle", "v3"},
         {"message", "No range between v1 and v3 was used for 30 s: there is no line of sight."},
         {"remedy", "Nothing to do while v3 is behind a corner."}});
  }
  if (is_lost(t_s)) {
    out.push_back(
        {{"level", "error"},
         {"name", "anchor"},
         {"message", fmt::format("v3 has not been heard for {:.0f} s.", t_s - kLostStart_s + 2)},
         {"remedy", "Drive v1 towards x 44, y 0, or order: rali operator assume-lost v3"}});
  }
  return out;
}

std::string mission_text(double t_s) {
  if (t_s >= kEnd_s) return "Finished: no frontier is left.";
  if (is_lost(t_s)) return "Round 3: the anchor is lost, v1 and v2 finish their moves.";
  const int anchor = anchor_at(t_s);
  return fmt::format("Round {}: {} stands, {} and {} explore.", anchor + 1, name_of(anchor),
                     name_of((anchor + 1) % 3), name_of((anchor + 2) % 3));
}

json anchor_state(double t_s) {
  const int anchor = anchor_at(t_s);
  const double since = anchor == 0 ? 0 : anchor == 1 ? kFirstHandOver_s : kSecondHandOver_s;
  json out = {{"vehicle", name_of(anchor)}, {"since_s", t_s - since}};
  if (is_lost(t_s)) {
    out["lost"] = {
        {"vehicle", "v3"},
        {"age_s", t_s - kLostStart_s + 2.0},
        {"position_m", position(2, kLostStart_s)},
        {"message", "v3 is not heard. v1 and v2 elect a new anchor as soon as both stand."},
        {"command", "rali operator assume-lost v3"}};
  }
  return out;
}

json table_move() {
  return {{"t_s", kTableMoves_s},
          {"term", 1},
          {"revision", 1 + static_cast<int>(kTableMoves_s / 2.0)},
          {"moved_poses", 74},
          {"moved_max_m", 0.67},
          {"moved_vehicle", "v3"}};
}

json table_at(double t_s) {
  const int revision = 1 + static_cast<int>(t_s / 2.0);
  json out = {{"term", anchor_at(t_s) + 1},
              {"revision", revision},
              {"age_s", std::fmod(t_s, 2.0)},
              {"poses", static_cast<int>(2.6 * t_s)},
              {"moved_poses", 3},
              {"moved_max_m", 0.02}};
  const json move = table_move();
  if (revision == move["revision"]) out.update(move);
  return out;
}

json sensors() {
  return {{{"name", "lidar"},
           {"topic", "/points"},
           {"rate_hz", 9.98},
           {"expected_hz", 10.0},
           {"gaps", 0},
           {"drops", 0},
           {"age_s", 0.06}},
          {{"name", "imu"},
           {"topic", "/imu"},
           {"rate_hz", 399.6},
           {"expected_hz", 400.0},
           {"gaps", 1},
           {"drops", 0},
           {"age_s", 0.01}},
          {{"name", "uwb"},
           {"topic", "/dev/ttyUSB0"},
           {"rate_hz", 43.1},
           {"expected_hz", 50.0},
           {"gaps", 4},
           {"drops", 0},
           {"age_s", 0.03}}};
}

}  // namespace

double gallery_error_m(double t_s) {
  return t_s < kTableMoves_s ? std::clamp(0.6 * (t_s - 40.0) / 50.0, 0.0, 0.6) : 0.0;
}

std::string state_at(double t_s) {
  json vehicles = json::array();
  double driven_m = 0.0;
  for (int v = 0; v < kVehicles; ++v) {
    vehicles.push_back(vehicle_at(v, t_s));
    for (double t = 0.0; t < t_s; t += 1.0) driven_m += pose_of(v, t).speed_mps;
  }
  const json state = {
      {"schema", 1},
      {"t_s", t_s},
      {"vehicle", "v1"},
      {"epoch", 1},
      {"frame", "map"},
      {"term", anchor_at(t_s) + 1},
      {"mode", vehicles[0]["mode"]},
      {"waits_for", waits_for(0, t_s)},
      {"mission",
       {{"round", anchor_at(t_s) + 1},
        {"state", mission_text(t_s)},
        {"distance_m", driven_m},
        {"area_m2", 3.4 * driven_m},
        {"finished", t_s >= kEnd_s}}},
      {"anchor", anchor_state(t_s)},
      {"vehicles", vehicles},
      {"links", links_at(t_s)},
      {"ranges", ranges_at(t_s)},
      {"frontiers", frontiers_at(t_s)},
      {"goals", goals_at(t_s)},
      {"degenerate_stretches", stretches_at(t_s)},
      {"table", table_at(t_s)},
      {"diagnostics", diagnostics_at(t_s)},
      {"sensors", sensors()},
      {"disk", {{"free_bytes", 41.2e9 - 2.4e5 * t_s}, {"state", "ok"}}},
      {"steps",
       {{"p50_s", 0.00042}, {"p99_s", 0.0016}, {"max_s", 0.0039}, {"queue", 0}, {"queue_max", 3}}},
      {"odometry", {{"latency_p50_s", 0.0118}, {"latency_p99_s", 0.0394}}}};
  json out = state;
  if (t_s >= kTableMoves_s) out["table_moves"] = json::array({table_move()});
  return out.dump();
}

std::string paths_at(double t_s) {
  json paths = json::array();
  for (int v = 0; v < kVehicles; ++v) {
    json times = json::array(), positions = json::array(), degenerate = json::array();
    for (double t = 0.0; t <= t_s; t += 1.0) {
      const Pose pose = pose_of(v, t);
      if (pose.at_rest && t > 0.0) continue;
      times.push_back(t);
      // A table also corrects earlier poses.
      const double error_m = v == 2 && t_s < kTableMoves_s ? gallery_error_m(t) : 0.0;
      positions.push_back({pose.x_m + error_m, pose.y_m + 0.5 * error_m, 0.1});
      degenerate.push_back(pose.degenerate ? 1 : 0);
    }
    paths.push_back({{"vehicle", name_of(v)},
                     {"t_s", times},
                     {"position_m", positions},
                     {"degenerate", degenerate}});
  }
  return json{{"t_s", t_s}, {"paths", paths}}.dump();
}

}  // namespace rali::view_demo
