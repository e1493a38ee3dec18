#pragma once

#include <functional>
#include <string>

#include "rali/eval/association.hpp"
#include "rali/sim/simulation.hpp"

namespace rali::accuracy {

/// What stands before the messages of a recording.
struct RecordingHead {
  sensor::Calibration calibration;  ///< nominal, as a user has it
  double way_m = 0.0;
};

/// What a recording tells: truth comes with each sweep, for its last point.
struct Listener {
  std::function<void(const RecordingHead&)> on_head;
  std::function<void(const sensor::ImuSample&)> on_imu;
  std::function<void(std::shared_ptr<const sensor::LidarScan>, const eval::StampedPose& truth)>
      on_scan;
};

/// Plays the recording of these options. With a cache folder, it is cast once and kept there as
/// <hash of all options>.rec; later runs read that file. A damaged file is cast anew.
[[nodiscard]] Status play(const sim::SimOptions& options, const std::string& cache_dir,
                          const Listener& listener);

}  // namespace rali::accuracy
