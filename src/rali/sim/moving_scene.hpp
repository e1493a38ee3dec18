#pragma once

#include <vector>

#include "rali/sim/pedestrians.hpp"
#include "rali/sim/trajectory.hpp"
#include "rali/sim/vehicle_look.hpp"

namespace rali::sim {

/// All moving objects that one LiDAR sees: people and the other vehicles. Cheap to copy; a copy
/// can be placed at another time, so that parts of a scan can be cast in parallel.
class MovingScene {
 public:
  /// Without moving objects.
  MovingScene() = default;

  explicit MovingScene(Pedestrians people) : people_(std::move(people)) {}

  /// @param trajectory  must outlive this scene and cover the requested times
  void add_vehicle(const VehicleLook& look, const Trajectory& trajectory);

  void place_people_at(double t_s);
  void place_vehicles_at(double t_s);

  void place_at(double t_s) {
    place_people_at(t_s);
    place_vehicles_at(t_s);
  }

  /// Shortens `hit` if a moving object intersects the ray before it.
  void cast(const geometry::Vec3& origin, const geometry::Vec3& direction, Hit& hit) const;

  [[nodiscard]] bool empty() const { return people_.empty() && vehicles_.empty(); }

 private:
  struct Vehicle {
    VehicleLook look;
    const Trajectory* trajectory;
    geometry::SE3 T_world_body;
  };

  Pedestrians people_;
  std::vector<Vehicle> vehicles_;
};

}  // namespace rali::sim
