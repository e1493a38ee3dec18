#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "place.hpp"
#include "rali/eval/association.hpp"

namespace rali::tunnel {

/// Header of a recording, before its messages.
struct RecordingHead {
  sensor::Calibration calibration;               ///< nominal, as known to a user
  geometry::Vec3 own_antenna_m, peer_antenna_m;  ///< nominal, each in its own body frame
  geometry::SE3 T_world_self, T_world_peer;      ///< true poses at the start
  Time t_start, t_end;
  double path_m = 0.0;
};

/// Callbacks for a recording; ground truth comes with each scan, for its last point, and each
/// range.
struct Listener {
  std::function<void(const RecordingHead&)> on_head;
  std::function<void(const sensor::ImuSample&)> on_imu;
  std::function<void(std::shared_ptr<const sensor::LidarScan>, const eval::StampedPose& truth)>
      on_scan;
  std::function<void(const sensor::RangeSample&, const sim::RangeTruth&)> on_range;
};

/// The scans of the driving vehicle, simulated once and kept. Everything else is simulated each
/// time it is played, so that the same path can be driven with other radios.
class Recording {
 public:
  /// @param cache_dir  folder for files with the scans; empty: none
  /// Errors: of make_setup(), of the cache folder.
  [[nodiscard]] static Result<Recording> make(const Place& place, const std::string& cache_dir);

  /// Errors: of the simulation.
  [[nodiscard]] Status play(const sim::UwbOptions& uwb, const Listener& listener) const;

  [[nodiscard]] const Setup& setup() const { return setup_; }

  [[nodiscard]] const Place& place() const { return place_; }

 private:
  struct Scan {
    Time t_start;
    sim::RawScan raw;
  };

  Recording(const Place& place, Setup setup) : place_(place), setup_(std::move(setup)) {}

  [[nodiscard]] Status cast();
  [[nodiscard]] bool load(const std::string& path);
  [[nodiscard]] Status save(const std::string& path) const;
  [[nodiscard]] std::string file_name() const;

  Place place_;
  Setup setup_;
  std::vector<Scan> scans_;
};

}  // namespace rali::tunnel
