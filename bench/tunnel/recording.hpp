#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "place.hpp"
#include "rali/eval/association.hpp"

namespace rali::tunnel {

/// What stands before the messages of a recording.
struct RecordingHead {
  sensor::Calibration calibration;               ///< nominal, as a user has it
  geometry::Vec3 own_antenna_m, peer_antenna_m;  ///< nominal, each in its body
  geometry::SE3 T_world_self, T_world_peer;      ///< truth at the start
  Time t_begin, t_end;
  double way_m = 0.0;
};

/// What a recording tells: truth comes with each sweep, for its last point, and with each range.
struct Listener {
  std::function<void(const RecordingHead&)> on_head;
  std::function<void(const sensor::ImuSample&)> on_imu;
  std::function<void(std::shared_ptr<const sensor::LidarScan>, const eval::StampedPose& truth)>
      on_scan;
  std::function<void(const sensor::RangeSample&, const sim::RangeTruth&)> on_range;
};

/// The sweeps of the driving vehicle, cast once and kept; the rest is made anew each time it is
/// played, so that the same way can be driven with other radios.
class Recording {
 public:
  /// @param cache_dir  keeps sweeps in files there; empty: casts
  /// Errors: of make_setup(), of the cache folder.
  [[nodiscard]] static Result<Recording> make(const Place& place, const std::string& cache_dir);

  /// Errors: of the simulation.
  [[nodiscard]] Status play(const sim::UwbOptions& uwb, const Listener& listener) const;

  [[nodiscard]] const Setup& setup() const { return setup_; }

  [[nodiscard]] const Place& place() const { return place_; }

 private:
  struct Sweep {
    Time t_begin;
    sim::RawSweep raw;
  };

  Recording(const Place& place, Setup setup) : place_(place), setup_(std::move(setup)) {}

  [[nodiscard]] Status cast();
  [[nodiscard]] bool load(const std::string& path);
  [[nodiscard]] Status save(const std::string& path) const;
  [[nodiscard]] std::string file_name() const;

  Place place_;
  Setup setup_;
  std::vector<Sweep> sweeps_;
};

}  // namespace rali::tunnel
