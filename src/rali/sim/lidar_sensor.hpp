#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/settings.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/lidar_scan.hpp"
#include "rali/sim/lidar_model.hpp"
#include "rali/sim/moving_scene.hpp"
#include "rali/sim/ray_caster.hpp"

namespace rali::sim {

/// Errors and limits of the ranging.
struct LidarOptions {
  double noise_m = 0.02;  ///< sd of the range
  /// Errors of each laser, constant over time and drawn once, so they move with the vehicle.
  /// A new VLP-16 has about 0.01 m and 0.05 deg (Glennie, Kusari, Facchin 2016).
  double laser_offset_m = 0.0;       ///< sd of the constant range error of a laser
  double laser_elevation_deg = 0.0;  ///< sd of the error of its elevation; rosettes have none
  double resolution_m = 0.002;  ///< step of the reported range; max_range_m fits in 65535 steps
  double min_range_m = 0.4;
  double max_range_m = 100.0;
  bool dropouts = true;          ///< weak returns (far, dark, grazing) are lost
  double mixed_fraction = 0.25;  ///< of points at range edges that lie between the surfaces

  /// Typical precision, resolution and range of this model's data sheet.
  [[nodiscard]] static LidarOptions of(Lidar kind);

  template <class V>
  void visit(V& v) {
    v("noise_m", noise_m, 0.0, 1.0, "sd of the range");
    v("laser_offset_m", laser_offset_m, 0.0, 0.2, "sd of each laser's constant range error");
    v("laser_elevation_deg", laser_elevation_deg, 0.0, 2.0, "sd of each laser's elevation error");
    v("resolution_m", resolution_m, 1e-5, 0.1, "step of the reported range");
    v("min_range_m", min_range_m, 0.0, 10.0, "nearer returns are lost");
    v("max_range_m", max_range_m, 1.0, 1000.0, "farther returns are lost");
    v("dropouts", dropouts, "weak returns get lost");
    v("mixed_fraction", mixed_fraction, 0.0, 1.0, "fraction of edge points between two surfaces");
  }
};

/// Raw output of one scan: counts per firing and laser, index firing * rings + ring. Three bytes
/// per ray: compact enough to store recordings.
struct RawScan {
  std::int64_t number = 0;                 ///< scans since the start
  std::vector<std::uint16_t> range_steps;  ///< times resolution_m; 0: no return
  std::vector<std::uint8_t> intensity;
};

/// The points of a scan that starts at t_start.
[[nodiscard]] std::shared_ptr<const sensor::LidarScan> expand(const RawScan& raw,
                                                              const LidarModel& model,
                                                              double resolution_m, Time t_start);

/// Simulates scans from poses.
class LidarSensor {
 public:
  using PoseAt = std::function<geometry::SE3(double t_s)>;  ///< T_world_lidar

  LidarSensor(Lidar kind, const LidarOptions& options, std::uint64_t seed);

  /// Measures scan `number`, which starts at start_s. Each ray starts at the sensor's pose at its
  /// own instant, with moving objects placed at that instant. `executor` casts rays in blocks; the
  /// result does not depend on it. pose_at must be safe to call from several threads. Valid until
  /// the next call.
  [[nodiscard]] const RawScan& measure_scan(std::int64_t number, double start_s,
                                            const PoseAt& pose_at, const RayCaster& world,
                                            const MovingScene& others, Executor& executor);

  /// The last scan.
  [[nodiscard]] const RawScan& raw() const { return raw_; }

  [[nodiscard]] const LidarModel& model() const { return model_; }

 private:
  /// Buffers for one block of firings, kept to avoid allocations per scan.
  struct Scratch {
    MovingScene others;
    std::vector<Ray> rays;
  };

  void cast_block(std::int64_t number, double start_s, const PoseAt& pose_at,
                  const RayCaster& world, Scratch& scratch, int begin, int end);
  /// Reported range [m] of a true hit, 0 if it was lost.
  [[nodiscard]] double measured_range_m(const Hit& hit, std::size_t ring, float neighbour_m);

  LidarModel model_;   ///< nominal model of the maker: used to compute the points
  LidarModel lasers_;  ///< actual lasers: used to cast the rays
  std::vector<double> laser_offset_m_;
  LidarOptions options_;
  Rng noise_, drop_, edge_;
  std::vector<float> before_m_;  ///< true range of each ring in the firing before
  std::vector<Hit> hits_;        ///< true hits of the scan
  std::vector<Scratch> scratch_;
  RawScan raw_;
};

}  // namespace rali::sim
