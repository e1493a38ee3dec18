#include "rali/scenario/recording/fleet_yaml.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

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

}  // namespace

std::string fleet_yaml(const sim::FleetSimulation& sim, const std::vector<std::string>& names,
                       RecordingFormat format, sim::Lidar lidar, bool with_imu) {
  std::string text =
      "# Made by rali simulate. Calibration as measured by hand: the truth is in truth/ only.\n"
      "schema: 1\n"
      "vehicles:\n";
  for (std::size_t v = 0; v < names.size(); ++v) {
    const sensor::Calibration& c = sim.calibration_nominal(static_cast<int>(v));
    text += fmt::format("  {}:\n    recording: {}\n", names[v], recording_name(names[v], format));
    text += fmt::format("    lidar: {{model: {}, T_body_lidar: {}}}\n", driver_of(lidar).model,
                        pose_text(c.T_body_lidar));
    text += fmt::format("    imu: {{{}T_body_imu: {}}}\n", with_imu ? "" : "topic: none, ",
                        pose_text(c.T_body_imu));
    text += fmt::format("    antennas: {{{}}}\n", antennas_text(sim.antennas(static_cast<int>(v))));
  }
  if (names.size() > 1) {
    text += "ranges: {sources: [{file: ranges.csv}]}\n";
    text += "radio: {file: radio.csv}\n";
  }
  return text;
}

}  // namespace rali::scenario
