#pragma once

#include "rali/odometry/robust/plane_map.hpp"
#include "rali/odometry/robust/settings.hpp"
#include "rali/odometry/robust/state.hpp"

namespace rali::odometry {

/// Lateral slip of a turning vehicle at the sensor: lateral speed per turn rate.
inline constexpr double kSlipPerRate_m = 0.3;

/// No sideways motion, no motion off the ground, and constant height above it (algorithms 2.6).
/// Each is learnt from the vehicle's own well observed motion and used only while the data agree: a
/// cart satisfies them, a drone, a hand or stairs never do. Each is applied only where the filter
/// is less certain than the constraint.
class VehicleConstraints {
 public:
  explicit VehicleConstraints(const ConstraintSettings& settings) : settings_(settings) {}

  /// Call after each scan's update. @param known all directions are observable in this scan.
  /// @param untouched projector on the translations along which the LiDAR is degenerate
  void update(FilterState& state, const geometry::Vec3& w_body_radps, const PlaneMap& map,
              bool known, const geometry::Mat3& untouched = geometry::Mat3::Zero());

  [[nodiscard]] bool non_holonomic_holds() const { return non_holonomic_holds_; }

  /// The vehicle moves along the ground, also sideways.
  [[nodiscard]] bool on_ground() const { return on_ground_; }

  [[nodiscard]] bool ground_holds() const { return ground_holds_; }

 private:
  void learn_direction(const geometry::Vec3& v_body, const geometry::Vec3& up_body);
  void constrain_sideways(FilterState& state, const geometry::Vec3& w_body_radps,
                          const geometry::Vec3& up) const;
  void constrain_climb(FilterState& state, const geometry::Vec3& w_body_radps,
                       const geometry::Vec3& up) const;
  void ground(FilterState& state, const PlaneMap& map, bool known, const geometry::Mat3& untouched);

  ConstraintSettings settings_;
  geometry::Mat3 directions_ =
      geometry::Mat3::Zero();  ///< exponentially weighted sum of v v^T / |v|^2
  geometry::Vec3 forward_body_ = geometry::Vec3::UnitX();
  bool non_holonomic_holds_ = false;
  double climb_ = 0.0;  ///< rms of the speed off the ground, per speed
  bool on_ground_ = false;
  double height_m_ = 0.0, height_var_m2_ = 0.0, height_weight_ = 0.0;
  bool ground_holds_ = false;
};

}  // namespace rali::odometry
