#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "place.hpp"
#include "rali/drive/output/corrected_path.hpp"
#include "rali/eval/association.hpp"
#include "rali/wire/byte_writer.hpp"

namespace rali::fleet_bench {

/// Points of a keyframe, in its body.
struct Points {
  std::vector<float> x_m, y_m, z_m, intensity;
  std::vector<std::uint16_t> ring;
};

/// One vehicle's mission: what came out of its software, and the truth.
struct Driven {
  geometry::SE3 T_world_start;  ///< truth of the body at the start of the recording
  double way_m = 0.0;
  eval::PoseList truth;                  ///< at the last point of every sweep
  std::vector<drive::PoseRecord> poses;  ///< as known when each sweep was processed
  drive::KeyframeCorrections smoothed;   ///< what the vehicle alone made of keyframes later
  std::vector<drive::KeyframeRecord> keyframes;
  std::vector<Points> points;      ///< by keyframe
  std::vector<wire::Bytes> facts;  ///< as the radio would carry them, in the order of making
};

/// All vehicles of one mission.
struct Mission {
  double duration_s = 0.0;
  double cpu_ms = 0.0;  ///< of the vehicles' software, all together
  std::vector<Driven> vehicles;
};

/// Drives the mission through the simulator and the vehicles' software, or reads it from the cache.
/// The vehicles know nothing of each other's starts. Errors: of the simulation, of settings, of
/// the cache folder.
[[nodiscard]] Result<Mission> drive_mission(const Place& place, const std::string& cache_dir);

/// The mission as one file. False: it is not there, of another version, or cut.
[[nodiscard]] bool load_mission(const std::string& path, Mission& mission);
[[nodiscard]] Status save_mission(const std::string& path, const Mission& mission);

}  // namespace rali::fleet_bench
