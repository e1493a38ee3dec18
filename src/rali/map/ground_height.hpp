#pragma once

#include <map>
#include <optional>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/map/keyframe_view.hpp"

namespace rali::map {

/// The plane on which a vehicle stands.
struct Ground {
  double below_body_m = 0.0;  ///< vertical distance from the body's origin to it
  geometry::Vec2 rise_map = geometry::Vec2::Zero();  ///< its rise per metre along x and y of map
};

/// The ground next to the vehicle: the lowest plane within 5 m, or 12 m, that holds many
/// points. It is level,
/// or, where more points lie on it then, square to z of the body: on an incline the vehicle stands
/// inclined, too. Empty if there is no such plane below the LiDAR.
[[nodiscard]] std::optional<Ground> ground_below(const KeyframeView& keyframe);

/// The ground of each keyframe with what the keyframes before say of its vehicle: the distance from
/// body to ground is constant, and its median rejects keyframes that took a bench for ground.
class VehicleGround {
 public:
  /// @param given_m distance from body to ground if the user knows it; 0: from the data
  explicit VehicleGround(double given_m) : given_m_(given_m) {}

  /// Empty as long as this vehicle has seen no ground.
  [[nodiscard]] std::optional<Ground> below(VehicleId vehicle, const KeyframeView& keyframe);

 private:
  double given_m_;
  std::map<VehicleId, std::vector<double>> distances_m_;  ///< per vehicle, sorted
};

}  // namespace rali::map
