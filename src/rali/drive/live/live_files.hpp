#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "rali/base/result.hpp"
#include "rali/drive/live/live_map.hpp"
#include "rali/drive/output/pose_files.hpp"
#include "rali/io/files/csv_writer.hpp"

namespace rali::drive {

/// Statistics of the live poses of one vehicle.
struct LiveTally {
  std::size_t poses = 0;
  Time t_joined;          ///< of the first
  std::size_t steps = 0;  ///< of T_map_odom, after the first pose
  FrameStep largest;
};

/// live/<v>.tum and .cov.csv, the poses in the map as known at the time, and live/<v>.steps.csv,
/// the steps of T_map_odom.
class LiveFiles {
 public:
  /// Errors: kMachine.
  [[nodiscard]] static Result<LiveFiles> create(const std::string& out_dir,
                                                const std::string& vehicle);
  [[nodiscard]] Status add(const LivePose& pose, const std::optional<FrameStep>& step);
  [[nodiscard]] Status close();

  [[nodiscard]] const LiveTally& tally() const { return tally_; }

 private:
  LiveFiles(PoseFiles poses, io::CsvWriter steps);

  PoseFiles poses_;
  io::CsvWriter steps_;
  LiveTally tally_;
};

}  // namespace rali::drive
