#include "rali/scenario/recording/fleet_yaml.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "rali/base/rng.hpp"

namespace rali::scenario {
namespace {

std::string point_text(const geometry::Vec3& p) {
  return fmt::format("[{:.4f}, {:.4f}, {:.4f}]", p.x(), p.y(), p.z());
}

std::string pose_text(const geometry::SE3& T) {
  const Eigen::Quaterniond q(T.R);
  return fmt::format("{{xyz_m: {}, quat_xyzw: [{:.6f}, {:.6f}, {:.6f}, {:.6f}]}}", point_text(T.p),
                     q.x(), q.y(), q.z(), q.w());
}

std::string antennas_text(const std::vector<sim::AntennaMount>& antennas) {
  std::string text;
  for (std::size_t i = 0; i < antennas.size(); ++i) {
    const std::string name = i == 0 ? "uwb" : fmt::format("uwb{}", i + 1);
    text += fmt::format("{}{}: {{xyz_m: {}}}", i == 0 ? "" : ", ", name,
                        point_text(antennas[i].p_nominal_m));
  }
  return text;
}

/// Accuracy of a position by tape measure and of a heading by eye.
constexpr double kTapeSigma_m = 0.2;
constexpr double kEyeSigma_deg = 3.0;

double yaw_rad(const geometry::SE3& T) { return std::atan2(T.R(1, 0), T.R(0, 0)); }

/// Gravity-aligned frame at a vehicle's first pose, with its heading along x.
geometry::SE3 level_start(const sim::FleetSimulation& sim, int vehicle) {
  geometry::SE3 T = sim.truth(vehicle, sim.t_start()).state.T_world_body;
  T.R = geometry::rotation_from_rpy(0.0, 0.0, yaw_rad(T));
  return T;
}

std::string priors_text(const sim::FleetSimulation& sim, const std::vector<std::string>& names,
                        std::uint64_t seed) {
  Rng rng(seed, "start poses");
  std::string text;
  for (std::size_t v = 1; v < names.size(); ++v) {
    const geometry::SE3 T = level_start(sim, 0).inverse() * level_start(sim, static_cast<int>(v));
    geometry::Vec3 p = T.p;
    for (double& x : p) x += kTapeSigma_m * rng.normal();
    const double yaw_deg = yaw_rad(T) * 180.0 / std::numbers::pi + kEyeSigma_deg * rng.normal();
    text += fmt::format(
        "  - {{vehicle: {}, relative_to: {}, xyz_m: [{:.2f}, {:.2f}, {:.2f}], yaw_deg: {:.1f}, "
        "sigma_m: {}, sigma_deg: {}}}\n",
        names[v], names[0], p.x(), p.y(), p.z(), yaw_deg, kTapeSigma_m, kEyeSigma_deg);
  }
  return text;
}

constexpr const char* kHead =
    "# Made by rali simulate. Calibration as measured by hand: the truth is in truth/ only.\n"
    "schema: 1\n"
    "vehicles:\n";

/// Calibration of one vehicle, and the topics of its sensors where they must be given.
std::string sensors_text(const sim::FleetSimulation& sim, std::size_t v,
                         const RecordingOptions& options, const std::string& lidar_topic,
                         const std::string& imu_topic) {
  const auto topic = [](const std::string& name) {
    return name.empty() ? std::string() : fmt::format("topic: {}, ", name);
  };
  const sensor::Calibration& c = sim.calibration_nominal(static_cast<int>(v));
  std::string text =
      fmt::format("    lidar: {{{}model: {}, T_body_lidar: {}}}\n", topic(lidar_topic),
                  driver_of(options.lidar).model, pose_text(c.T_body_lidar));
  text +=
      fmt::format("    imu: {{{}T_body_imu: {}}}\n",
                  options.with_imu ? topic(imu_topic) : "topic: none, ", pose_text(c.T_body_imu));
  if (sim.vehicles() == 1) return text;  // no ranges: antennas would have no effect
  return text +
         fmt::format("    antennas: {{{}}}\n", antennas_text(sim.antennas(static_cast<int>(v))));
}

}  // namespace

std::string fleet_yaml(const sim::FleetSimulation& sim, const std::vector<std::string>& names,
                       const RecordingOptions& options) {
  std::string text = kHead;
  for (std::size_t v = 0; v < names.size(); ++v) {
    text += fmt::format("  {}:\n    recording: {}\n", names[v],
                        recording_name(names[v], options.format));
    text += sensors_text(sim, v, options, {}, {});
  }
  if (names.size() > 1) {
    text += "ranges: {sources: [{file: ranges.csv}]}\n";
    text += "radio: {file: radio.csv}\n";
    if (options.priors) text += "priors:\n" + priors_text(sim, names, options.seed);
  }
  return text;
}

std::string live_fleet_yaml(const sim::FleetSimulation& sim, const std::vector<std::string>& names,
                            const RecordingOptions& options, const LiveNetwork& network) {
  std::string text = kHead;
  for (std::size_t v = 0; v < names.size(); ++v) {
    text += fmt::format("  {}:\n    live: {{address: 127.0.0.{}}}\n", names[v], v + 1);
    text += sensors_text(sim, v, options, live_topic(names[v], driver_of(options.lidar).topic),
                         live_topic(names[v], kImuTopic));
  }
  text += fmt::format("live: {{ros_domain: {}, fleet_domain: {}", network.ros_domain,
                      network.fleet_domain);
  text += names.size() > 1 ? fmt::format(", key_file: {}}}\n", network.key_file) : "}\n";
  if (names.size() > 1) {
    text += fmt::format("ranges: {{sources: [{{topic: {}}}]}}\n", kLiveRangeTopic);
    if (options.priors) text += "priors:\n" + priors_text(sim, names, options.seed);
  }
  return text;
}

std::string live_topic(const std::string& vehicle, std::string_view topic) {
  return fmt::format("/{}/{}", vehicle, topic.starts_with('/') ? topic.substr(1) : topic);
}

}  // namespace rali::scenario
