#pragma once

#include <functional>
#include <memory>

#include "rali/base/settings.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/lidar_scan.hpp"
#include "rali/sim/lidar_model.hpp"
#include "rali/sim/pedestrians.hpp"
#include "rali/sim/ray_caster.hpp"

namespace rali::sim {

/// Errors and limits of the ranging.
struct LidarOptions {
  double noise_m = 0.02;  ///< sd of the range
  double min_range_m = 0.4;
  double max_range_m = 100.0;
  bool dropouts = true;       ///< weak returns (far, dark, grazing) get lost
  double mixed_share = 0.25;  ///< of points at range edges that lie between the surfaces

  template <class V>
  void visit(V& v) {
    v("noise_m", noise_m, 0.0, 1.0, "sd of the range");
    v("min_range_m", min_range_m, 0.0, 10.0, "nearer returns are lost");
    v("max_range_m", max_range_m, 1.0, 1000.0, "farther returns are lost");
    v("dropouts", dropouts, "weak returns get lost");
    v("mixed_share", mixed_share, 0.0, 1.0, "share of edge points between two surfaces");
  }
};

/// Turns poses into sweeps.
class LidarSensor {
 public:
  using PoseAt = std::function<geometry::SE3(double t_s)>;  ///< T_world_lidar

  LidarSensor(Lidar kind, const LidarOptions& options, std::uint64_t seed);

  /// Sweep number `sweep` starting at sweep * sweep_s(): each ray starts from the sensor's pose
  /// at its own instant.
  [[nodiscard]] std::shared_ptr<const sensor::LidarScan> sweep(std::int64_t sweep, Time t_begin,
                                                               const PoseAt& pose_at,
                                                               const RayCaster& world,
                                                               Pedestrians& people);

  [[nodiscard]] const LidarModel& model() const { return model_; }

 private:
  struct Measured {
    float range_m;
    float intensity;
  };

  [[nodiscard]] Measured measure(const Hit& hit, float neighbour_m);

  LidarModel model_;
  LidarOptions options_;
  Rng noise_, drop_, edge_;
  std::vector<float> before_m_;  ///< true range of each ring in the firing before
};

}  // namespace rali::sim
