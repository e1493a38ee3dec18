#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rali/geometry/types.hpp"

/// State for the live page, once a second. Fields and their meaning: src/rali/view/README.md;
/// unknown values are left out of the JSON.
namespace rali::host {

struct StateEllipse {
  double major_m = 0.0, minor_m = 0.0, angle_rad = 0.0;
};

struct StateVehicle {
  std::string name;
  std::optional<geometry::Vec3> position_m;
  double yaw_rad = 0.0;
  std::string frame = "map";
  std::optional<StateEllipse> ellipse;
  std::optional<double> sigma_z_m;
  std::optional<double> age_s;  ///< none: never received
  std::string role, mode, waits_for;
  bool at_rest = false;
  std::optional<geometry::Vec3> degenerate_axis;
  double degenerate_since_s = 0.0;
  std::optional<double> battery, speed_mps;
};

struct StateLink {
  std::string from, to;
  bool connected = false;
  std::optional<double> rate_Bps, age_s, rssi_dbm;
  std::uint64_t refused = 0, forged = 0, repeated = 0;
};

struct StateRange {
  std::string from, to;
  double range_m = 0.0;
  bool used = false;
  std::string reason;
  double age_s = 0.0;
};

struct StateFrontier {
  geometry::Vec3 position_m;
  double size_m = 0.0;
};

struct StateGoal {
  std::string vehicle;
  std::vector<geometry::Vec3> path_m;  ///< not empty; its end is the goal
};

struct StateTable {
  std::uint64_t term = 0;
  std::size_t poses = 0, moved_poses = 0;
  double moved_max_m = 0.0;
  std::string moved_vehicle;
  std::uint32_t revision = 0;
};

struct StateAnchorLost {
  std::string vehicle, message, command;
  double age_s = 0.0;
  std::optional<geometry::Vec3> position_m;
};

struct StateAnchor {
  std::string vehicle;
  double since_s = 0.0;
  std::optional<StateAnchorLost> lost;
};

enum class DiagnosticLevel : std::uint8_t { kOk, kWarn, kError, kStale };

/// One line of /diagnostics.
struct DiagnosticLine {
  DiagnosticLevel level = DiagnosticLevel::kOk;
  std::string name, message, remedy;
  std::optional<double> age_s;
};

struct StateSensor {
  std::string name, topic;
  double rate_hz = 0.0;
  std::uint64_t drops = 0;
  std::optional<double> age_s;
};

struct StateDisk {
  std::uint64_t free_bytes = 0;
  std::string state = "ok", message;
};

struct LiveState {
  double t_s = 0.0;
  std::string vehicle;
  std::uint32_t epoch = 0;
  std::string frame = "local";
  std::uint64_t term = 0;
  std::string mode, waits_for;
  std::size_t round = 0;
  std::string mission;
  double distance_m = 0.0;
  bool finished = false;
  std::optional<StateAnchor> anchor;
  std::vector<StateVehicle> vehicles;
  std::vector<StateLink> links;
  std::vector<StateRange> ranges;
  std::vector<StateFrontier> frontiers;
  std::vector<StateGoal> goals;
  std::optional<StateTable> table;
  std::vector<DiagnosticLine> diagnostics;
  std::vector<StateSensor> sensors;
  std::optional<StateDisk> disk;
  double step_p50_s = 0.0, step_p99_s = 0.0, step_max_s = 0.0;
  std::size_t queue = 0, queue_max = 0;
  double latency_p50_s = 0.0, latency_p99_s = 0.0;
};

/// A path for /rali/paths.
struct StatePath {
  std::string vehicle;
  std::vector<double> t_s;
  std::vector<geometry::Vec3> position_m;
  std::vector<bool> degenerate;
};

[[nodiscard]] std::string state_json(const LiveState& state);
[[nodiscard]] std::string paths_json(double t_s, const std::vector<StatePath>& paths);

/// Answer of /healthz. @return whether the vehicle is mapping
[[nodiscard]] bool health_json(const LiveState& state, std::string& json);

/// Answer of /metrics: Prometheus text.
[[nodiscard]] std::string metrics_text(const LiveState& state);

}  // namespace rali::host
