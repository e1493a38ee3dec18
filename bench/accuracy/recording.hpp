#pragma once

#include <functional>
#include <string>

#include "rali/eval/association.hpp"
#include "rali/sim/simulation.hpp"

namespace rali::accuracy {

/// Header of a recording, before its messages.
struct RecordingHead {
  sensor::Calibration calibration;  ///< nominal, as known to a user
  double path_m = 0.0;
};

/// Callbacks for a recording; each scan comes with the true pose at its last point.
struct Listener {
  std::function<void(const RecordingHead&)> on_head;
  std::function<void(const sensor::ImuSample&)> on_imu;
  std::function<void(std::shared_ptr<const sensor::LidarScan>, const eval::StampedPose& truth)>
      on_scan;
};

/// Plays the recording of these options. With a cache folder, it is simulated once and stored there
/// as <hash of all options>.rec; later runs read that file. A damaged file is simulated again.
[[nodiscard]] Status play(const sim::SimOptions& options, const std::string& cache_dir,
                          const Listener& listener);

}  // namespace rali::accuracy
