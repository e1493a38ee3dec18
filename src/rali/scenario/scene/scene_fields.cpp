#include "rali/scenario/scene/scene_fields.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include <fmt/format.h>

#include "rali/config/suggest.hpp"

namespace rali::scenario {

using config::CustomTarget;
using config::FieldCollector;
using config::FieldList;
using config::Node;

namespace {

/// Full range of the seed: a double would lose its last digits.
CustomTarget seed_field(std::uint64_t& seed) {
  CustomTarget target;
  target.type = "a whole number from 0 to 18446744073709551615";
  target.decode = [&seed, type = target.type](const Node& node, const std::string& key) -> Status {
    std::uint64_t value = 0;
    const char* const end = node.text.data() + node.text.size();
    const auto [stop, code] = std::from_chars(node.text.data(), end, value);
    if (node.kind != Node::Kind::kScalar || code != std::errc() || stop != end) {
      return config::not_allowed(node, key, type);
    }
    seed = value;
    return {};
  };
  target.encode = [&seed] { return fmt::format("{}", seed); };
  return target;
}

/// A number of vehicles, or a list of them.
CustomTarget vehicles_field(SceneSetup& setup) {
  CustomTarget target;
  target.type = fmt::format("1 to {}, or a list of vehicles", sim::kVehiclesMax);
  target.decode = [&setup, type = target.type](const Node& node, const std::string& key) -> Status {
    long long count = 0;
    setup.vehicles.clear();
    if (node.kind == Node::Kind::kSequence) {
      if (auto status = list_of(setup.vehicles).decode(node, key); !status) return status;
      count = static_cast<long long>(node.children.size());
    } else if (node.kind != Node::Kind::kScalar || !config::parse_integer(node.text, count)) {
      return config::not_allowed(node, key, type);
    }
    if (count < 1 || count > sim::kVehiclesMax) {
      return fail(ErrorCode::kUsage, node.where,
                  fmt::format("{} vehicles; a scene takes 1 to {}", count, sim::kVehiclesMax));
    }
    setup.fleet.vehicles = static_cast<int>(count);
    return {};
  };
  target.encode = [&setup] {
    return setup.vehicles.empty() ? fmt::format("{}", setup.fleet.vehicles)
                                  : list_of(setup.vehicles).encode();
  };
  return target;
}

/// Index of "v2", or an error that lists the names.
Result<int> vehicle_of(const std::string& name, const std::string& where, int vehicles) {
  std::vector<std::string> names;
  for (int i = 0; i < vehicles; ++i) {
    names.push_back(vehicle_name(i));
    if (names.back() == name) return i;
  }
  return fail(
      ErrorCode::kUsage, where,
      fmt::format("{} is no vehicle of this scene", config::yaml_quoted(name.substr(0, 60))),
      config::suggestion("", names));
}

Result<SceneRound> round_of(const Node& node, const std::string& key, int vehicles) {
  SceneRound round;
  round.where = node.where;
  round.routes.resize(static_cast<std::size_t>(vehicles));
  round.route_where.resize(static_cast<std::size_t>(vehicles));
  if (node.kind != Node::Kind::kMap) {
    return config::not_allowed(node, key, "{anchor: v1, routes: {v2: [[x, y], ...]}}");
  }
  for (const Node& child : node.children) {
    if (child.key == "pause_s") {
      constexpr double kLongest_s = 3600.0;
      const auto pause = config::number_or(round.pause_s, "auto", 0.0, kLongest_s);
      if (auto status = pause.decode(child, key + ".pause_s"); !status) {
        return tl::make_unexpected(status.error());
      }
    } else if (child.key == "anchor") {
      if (child.kind == Node::Kind::kScalar && child.text == "none") continue;
      const auto anchor = vehicle_of(child.text, child.where, vehicles);
      if (!anchor) return tl::make_unexpected(anchor.error());
      round.anchor = *anchor;
    } else if (child.key == "routes" && child.kind == Node::Kind::kMap) {
      for (const Node& route : child.children) {
        const auto vehicle = vehicle_of(route.key, route.key_where, vehicles);
        if (!vehicle) return tl::make_unexpected(vehicle.error());
        const auto i = static_cast<std::size_t>(*vehicle);
        round.route_where[i] = route.where;
        const std::string name = fmt::format("{}.routes.{}", key, route.key);
        if (auto status = decode_path(route, name, round.routes[i]); !status) {
          return tl::make_unexpected(status.error());
        }
      }
    } else if (child.key == "routes") {
      return config::not_allowed(child, key + ".routes", "{v2: [[x, y], ...]}");
    } else {
      return fail(ErrorCode::kUsage, child.key_where,
                  fmt::format("unknown key '{}'", child.key.substr(0, 80)),
                  config::suggestion(child.key, {"anchor", "routes", "pause_s"}));
    }
  }
  const auto anchor = static_cast<std::size_t>(std::max(round.anchor, 0));
  if (round.anchor >= 0 && !round.routes[anchor].empty()) {
    return fail(ErrorCode::kUsage, round.route_where[anchor],
                fmt::format("{} is the anchor of this round, so it has no way",
                            vehicle_name(round.anchor)));
  }
  return round;
}

CustomTarget rounds_field(SceneSetup& setup) {
  CustomTarget target;
  target.type = "a list of rounds";
  target.decode = [&setup, type = target.type](const Node& node, const std::string& key) -> Status {
    if (node.kind != Node::Kind::kSequence) return config::not_allowed(node, key, type);
    setup.rounds.clear();
    for (const Node& child : node.children) {
      auto round = round_of(child, key, setup.fleet.vehicles);
      if (!round) return tl::make_unexpected(round.error());
      setup.rounds.push_back(std::move(*round));
    }
    return {};
  };
  target.encode = [&setup] {
    std::string text = "[";
    for (const SceneRound& round : setup.rounds) {
      text += fmt::format("{}{{anchor: {}, ", text.size() > 1 ? ", " : "",
                          round.anchor < 0 ? "none" : vehicle_name(round.anchor));
      if (round.pause_s) text += fmt::format("pause_s: {}, ", *round.pause_s);
      text += "routes: {";
      bool first = true;
      for (std::size_t i = 0; i < round.routes.size(); ++i) {
        if (round.routes[i].empty()) continue;
        text += fmt::format("{}{}: {}", first ? "" : ", ", vehicle_name(static_cast<int>(i)),
                            encode_path(round.routes[i]));
        first = false;
      }
      text += "}}";
    }
    return text + "]";
  };
  return target;
}

void collect_mesh(MeshSource& mesh, const std::string& folder, FieldCollector& v) {
  v.custom("mesh.file", config::path_or_none(mesh.file, folder), "a .ply, .obj or .stl file");
  v.choice("mesh.units", mesh.units, kUnitNames, "unit of its coordinates");
  v("mesh.scale", mesh.scale, 1e-6, 1e6, "applied after the units");
  v.choice("mesh.up", mesh.up, kUpNames, "its upward axis");
  v("mesh.reflectivity", mesh.reflectivity, 0.0, 1.0, "where the file has none");
}

void collect_place(SceneSetup& setup, const std::string& folder, FieldCollector& v) {
  switch (setup.place) {
    case PlaceKind::kScene:
      v.choice("scene", setup.scene, sim::kSceneNames, "a place that comes with the program");
      break;
    case PlaceKind::kFloorPlan:
      v.group("floor_plan", setup.floor_plan, "");
      break;
    case PlaceKind::kTunnel:
      v.group("tunnel", setup.tunnel, "");
      break;
    case PlaceKind::kMine:
      v.group("mine", setup.mine, "");
      break;
    case PlaceKind::kRamp:
      v.group("ramp", setup.ramp, "");
      break;
    case PlaceKind::kMesh:
      collect_mesh(setup.mesh, folder, v);
      break;
  }
}

}  // namespace

FieldList scene_fields(SceneSetup& setup, const std::string& folder) {
  FieldList fields;
  FieldCollector v("", fields);
  sim::SimOptions& o = setup.fleet.vehicle;
  v.custom("seed", seed_field(o.seed), "changes the place, the motion and the noise");
  collect_place(setup, folder, v);
  v.custom("vehicles", vehicles_field(setup), "how many, or each with start and route");
  v.custom("rounds", rounds_field(setup), "who stands and who drives where; empty: as the routes");
  v("duration_s", o.duration_s, 0.0, 36000.0, "0: all rounds");
  v("pedestrians", o.pedestrians, 0, 1000, "people who walk along the route");
  v("standing_people", o.standing_people, 0, 1000, "people who stand beside it");
  v("crossing_people", o.crossing_people, 0, 1000, "people who walk from side to side of it");
  v.custom("escorts", list_of(o.escorts), "who goes along with a vehicle");
  v.choice("lidar", o.lidar, sim::kLidarNames, "the sensor");
  v("with_imu", o.with_imu, "the vehicles have an inertial sensor");
  v("imu_apart", o.imu_apart, "it is turned by 90 deg and 10 cm beside the body");
  v("calibration_error_m", o.calibration_error_m, 0.0, 1.0, "of the nominal LiDAR position");
  v("calibration_error_deg", o.calibration_error_deg, 0.0, 45.0, "of the nominal LiDAR rotation");
  v("antennas", setup.fleet.antennas, 1, 2, "UWB antennas of each vehicle");
  v.group("motion", o.motion, "");
  v.group("ranging", o.ranging, "");
  v.group("imu", o.imu, "");
  setup.fleet.visit(v);
  return fields;
}

}  // namespace rali::scenario
