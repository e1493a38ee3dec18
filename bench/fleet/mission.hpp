#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "place.hpp"
#include "rali/drive/output/corrected_path.hpp"
#include "rali/eval/association.hpp"
#include "rali/wire/byte_writer.hpp"

namespace rali::fleet_bench {

/// Points of a keyframe in its body frame.
struct Points {
  std::vector<float> x_m, y_m, z_m, intensity;
  std::vector<std::uint16_t> ring;
};

/// One vehicle's mission: the outputs of its software, and ground truth.
struct Driven {
  geometry::SE3 T_world_start;  ///< true body pose at the start of the recording
  double path_m = 0.0;
  eval::PoseList truth;                  ///< at the last point of every scan
  std::vector<drive::PoseRecord> poses;  ///< live estimate at the time of processing
  drive::KeyframeCorrections smoothed;   ///< the vehicle's own later corrections of keyframes
  std::vector<drive::KeyframeRecord> keyframes;
  std::vector<Points> points;      ///< by keyframe
  std::vector<wire::Bytes> facts;  ///< as sent by radio, in the order of creation
};

/// All vehicles of one mission.
struct Mission {
  double duration_s = 0.0;
  double cpu_ms = 0.0;  ///< total of all vehicles' software
  std::vector<Driven> vehicles;
};

/// Runs the mission through the simulator and the vehicles' software, or reads it from the cache.
/// The vehicles do not receive each other's start poses. Errors: of the simulation, of settings, of
/// the cache folder.
[[nodiscard]] Result<Mission> drive_mission(const Place& place, const std::string& cache_dir);

/// The mission as one file. False: it is missing, of another version, or truncated.
[[nodiscard]] bool load_mission(const std::string& path, Mission& mission);
[[nodiscard]] Status save_mission(const std::string& path, const Mission& mission);

}  // namespace rali::fleet_bench
