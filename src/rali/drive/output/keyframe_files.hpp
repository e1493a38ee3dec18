#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/map/keyframe_view.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// What stays in memory of a keyframe; its points are on disk.
struct KeyframeRecord {
  KeyframeId id;
  Time t;
  geometry::SE3 T_local_body;
  geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< of geometry::boxplus
  geometry::SE3 T_previous_this;
  geometry::Mat6 information_relative = geometry::Mat6::Zero();
  geometry::SE3 T_body_lidar;
  std::size_t points = 0;
  bool has_rings = true;  ///< false: the laser of each point is not known
  bool diverged = false;  ///< left out of the map
  std::string file;       ///< relative to the output folder
};

/// Writes keyframes/<v>/<seq>.pcd one by one, each completely or not at all. Errors: kMachine.
[[nodiscard]] Result<KeyframeRecord> write_keyframe(const std::string& out_dir,
                                                    const std::string& vehicle,
                                                    const vehicle::KeyframeAdded& added);

/// The keyframes read back from disk, placed by T_map_local; diverged ones are left out.
/// @param records and out_dir must outlive the stream.
[[nodiscard]] map::KeyframeStream keyframe_stream(const std::string& out_dir,
                                                  const std::vector<KeyframeRecord>& records,
                                                  const geometry::SE3& T_map_local);

/// Removes the keyframe files of a vehicle, and their folder if it is empty then.
void remove_keyframes(const std::string& out_dir, const std::string& vehicle,
                      const std::vector<KeyframeRecord>& records);

/// Text of keyframes.csv.
struct VehicleKeyframes {
  std::string vehicle;
  geometry::SE3 T_map_local;
  const std::vector<KeyframeRecord>* records = nullptr;
};

[[nodiscard]] std::string keyframes_text(const std::vector<VehicleKeyframes>& vehicles,
                                         bool with_files);

}  // namespace rali::drive
