#pragma once

#include <vector>

#include "rali/base/rng.hpp"
#include "rali/sim/ray_caster.hpp"
#include "rali/sim/route.hpp"
#include "rali/sim/trajectory.hpp"
#include "rali/sim/world.hpp"

namespace rali::sim {

/// Number of people by activity.
struct Crowd {
  int walking = 0;   ///< to and fro along the route
  int standing = 0;  ///< beside the route, all the time
  int crossing = 0;  ///< from side to side of the route
};

/// A person who stands still, then moves at a constant distance from a vehicle.
struct Escort {
  int vehicle = 0;
  double gap_m = 2.0;                  ///< ahead of the vehicle along its path; negative: behind
  double side_m = 0.0;                 ///< to the left of that path
  double start_s = 0.0, end_s = 30.0;  ///< since the start; stands still before and after
  bool cart = false;                   ///< a vehicle outside the fleet instead of a person

  template <class V>
  void visit(V& v) {
    v("vehicle", vehicle, 0, kVehiclesMax - 1, "index of the vehicle it goes with");
    v("gap_m", gap_m, -100.0, 100.0, "ahead along the vehicle's path, negative: behind");
    v("side_m", side_m, -20.0, 20.0, "to the left of that path");
    v("start_s", start_s, 0.0, 36000.0, "stands until then");
    v("end_s", end_s, 0.0, 36000.0, "and from then on");
    v("cart", cart, "a vehicle of nobody's fleet instead of a person");
  }
};

/// People: trunk and legs as upright cylinders, a sphere as head. Only rays interact with them.
class Pedestrians {
 public:
  /// Without people.
  Pedestrians() = default;

  /// @param route  must outlive this object
  /// @param free_width_m  room on each side of the route
  Pedestrians(const Route& route, const Crowd& crowd, double free_width_m, std::uint64_t seed);

  /// Adds a person who follows `trajectory`, which must outlive this object.
  void add_escort(const Escort& escort, const Trajectory& trajectory, double body_height_m);

  /// Moves all people to their positions t_s after the start.
  void place_at(double t_s);

  /// Shortens `hit` if a person intersects the ray before it.
  void cast(const geometry::Vec3& origin, const geometry::Vec3& direction, Hit& hit) const;

  [[nodiscard]] bool empty() const { return people_.empty() && escorts_.empty(); }

  /// Positions of all people: for checks and pictures.
  [[nodiscard]] std::vector<geometry::Vec3> positions() const;

 private:
  struct Body {
    geometry::Vec3 feet = geometry::Vec3::Zero();
    geometry::Vec2 leg_left = geometry::Vec2::Zero();
    geometry::Vec2 leg_right = geometry::Vec2::Zero();
  };

  struct Person : Body {
    double middle_m, reach_m, speed_mps, phase_s, side_m;  // walk along the route
    bool crosses = false;
  };

  struct Companion : Body {
    Escort escort;
    const Trajectory* trajectory;
    double body_height_m;
    geometry::SE3 T_world_cart;
  };

  void place(Companion& companion, double t_s) const;
  static void put(Body& body, const geometry::Vec3& feet, const geometry::Vec3& ahead,
                  double walked_m);
  static void cast_body(const Body& body, const geometry::Vec3& origin,
                        const geometry::Vec3& direction, Hit& hit);

  const Route* route_ = nullptr;
  std::vector<Person> people_;
  std::vector<Companion> escorts_;
};

}  // namespace rali::sim
