#include "rali/sim/moving_scene.hpp"

namespace rali::sim {

void MovingScene::add_vehicle(const VehicleLook& look, const Trajectory& trajectory) {
  vehicles_.push_back({look, &trajectory, trajectory.pose_at(0.0)});
}

void MovingScene::place_people_at(double t_s) { people_.place_at(t_s); }

void MovingScene::place_vehicles_at(double t_s) {
  for (Vehicle& v : vehicles_) v.T_world_body = v.trajectory->pose_at(t_s);
}

void MovingScene::cast(const geometry::Vec3& origin, const geometry::Vec3& direction,
                       Hit& hit) const {
  people_.cast(origin, direction, hit);
  for (const Vehicle& v : vehicles_) meet_vehicle(v.look, v.T_world_body, origin, direction, hit);
}

}  // namespace rali::sim
