#pragma once

#include <vector>

#include "rali/base/rng.hpp"
#include "rali/sim/ray_caster.hpp"
#include "rali/sim/route.hpp"

namespace rali::sim {

/// People who walk to and fro along the route: trunk and legs as upright cylinders, a ball for
/// the head. Only rays see them; they never stop.
class Pedestrians {
 public:
  /// Nobody.
  Pedestrians() = default;

  /// @param route  must outlive this
  /// @param free_width_m  room on each side of the route
  Pedestrians(const Route& route, int count, double free_width_m, std::uint64_t seed);

  /// Moves everybody to t_s after the start.
  void place_at(double t_s);

  /// Shortens `hit` if somebody stands in the way of the ray.
  void cast(const geometry::Vec3& origin, const geometry::Vec3& direction, Hit& hit) const;

  [[nodiscard]] bool empty() const { return people_.empty(); }

  /// Where they stand: for checks and pictures.
  [[nodiscard]] std::vector<geometry::Vec3> positions() const;

 private:
  struct Person {
    double middle_m, reach_m, speed_mps, phase_s, side_m;  // walk along the route
    geometry::Vec3 feet = geometry::Vec3::Zero();
    geometry::Vec2 leg_left = geometry::Vec2::Zero();
    geometry::Vec2 leg_right = geometry::Vec2::Zero();
  };

  const Route* route_ = nullptr;
  std::vector<Person> people_;
};

}  // namespace rali::sim
