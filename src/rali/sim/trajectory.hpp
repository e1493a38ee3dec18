#pragma once

#include <optional>
#include <vector>

#include "rali/geometry/se3.hpp"
#include "rali/sim/jolts.hpp"

namespace rali::sim {

/// Exact pose and derivatives of a vehicle.
struct MotionState {
  geometry::SE3 T_world_body;
  geometry::Vec3 v_world_mps = geometry::Vec3::Zero();
  geometry::Vec3 a_world_mps2 = geometry::Vec3::Zero();
  geometry::Vec3 omega_body_radps = geometry::Vec3::Zero();
  geometry::Vec3 alpha_body_radps2 = geometry::Vec3::Zero();  ///< derivative of omega_body
};

/// Motion as a uniform cubic B-spline over (x, y, z, roll, pitch, yaw): twice continuously
/// differentiable, so rates and specific force are exact derivatives of the pose. The spline *is*
/// the ground truth; the source of the control points needs no derivatives.
/// Pitch must stay away from +-90 deg.
class Trajectory {
 public:
  using Control = geometry::Vec6;  ///< x y z [m], roll pitch yaw [rad, unwrapped]

  /// Control point i acts around i * spacing_s. Before the first and after the last second
  /// control point the vehicle is at standstill. Needs at least four control points.
  Trajectory(std::vector<Control> controls, double spacing_s);

  /// Adds one control point: the motion continues for another spacing_s. Earlier results of at() do
  /// not change.
  void append(const Control& control);

  /// Adds these offsets to the body pose from now on. The derivatives of at() stay those of the
  /// smooth motion.
  void add_jolts(const Jolts& jolts);

  /// State t_s seconds after the start; t_s is at least 0. From one spacing after duration_s() on
  /// the vehicle is at standstill at its final pose.
  [[nodiscard]] MotionState at(double t_s) const;
  /// Pose only; cheaper.
  [[nodiscard]] geometry::SE3 pose_at(double t_s) const;

  /// Acceleration that an inertial sensor measures from the steps alone at t_s, averaged over the
  /// sample that ends there [m/s^2, world].
  [[nodiscard]] geometry::Vec3 measured_jolt_mps2(double t_s, double sample_s) const;

  /// Horizontal distance travelled after t_s.
  [[nodiscard]] double distance_m(double t_s) const;

  /// Time at which that distance has been travelled; at a standstill, its end.
  [[nodiscard]] double time_at_distance_s(double distance_m) const;

  [[nodiscard]] double duration_s() const;
  /// Length of the driven path [m].
  [[nodiscard]] double length_m() const;

 private:
  struct Place {
    std::size_t index;  ///< first of the four control points
    double u;           ///< 0..1 within the span
  };

  [[nodiscard]] Place place(double t_s) const;
  [[nodiscard]] geometry::SE3 smooth_pose_at(const Place& place) const;
  [[nodiscard]] geometry::Vec6 jolt_at(double t_s) const;

  std::vector<Control> controls_;
  std::vector<double> travelled_m_;  ///< along the control points, horizontally
  double spacing_s_;
  std::optional<Jolts> jolts_;
};

}  // namespace rali::sim
