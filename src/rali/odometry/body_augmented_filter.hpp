#pragma once

#include "rali/odometry/augmented_filter.hpp"

namespace rali::odometry {

/// d(boxplus of the body) / d(boxplus of the IMU) where odom is turned by R_odom_inner.
[[nodiscard]] geometry::Mat6 body_jacobian(const geometry::SE3& T_inner_imu,
                                           const geometry::SE3& T_imu_body,
                                           const geometry::Mat3& R_odom_inner);

/// View of a filter that runs in the IMU frame: poses, derivatives and shifts are those of the body
/// in its own odom. The augmented states are unchanged.
class BodyAugmentedFilter final : public AugmentedFilter {
 public:
  BodyAugmentedFilter(AugmentedFilter& inner, const geometry::SE3& T_imu_body)
      : inner_(inner), T_imu_body_(T_imu_body) {}

  void set_odom(const geometry::SE3& T_odom_inner) { T_odom_inner_ = T_odom_inner; }

  [[nodiscard]] std::optional<Moment> advance_to(Time t) override;

  [[nodiscard]] const AugmentedStates& augmented() const override { return inner_.augmented(); }

  int add_states(const AugmentedStates::Vector& mean, const AugmentedStates::Matrix& covariance,
                 const AugmentedRowList& rows) override {
    return inner_.add_states(mean, covariance, seen_inside(rows));
  }

  void remove_states(int first, int n) override { inner_.remove_states(first, n); }

  void walk_side(int index, double variance) override { inner_.walk_side(index, variance); }

  [[nodiscard]] double variance(const AugmentedMeasurement& measurement) const override {
    return inner_.variance(seen_inside(measurement));
  }

  geometry::Vec3 apply(const AugmentedMeasurement& measurement, double R) override {
    return T_odom_inner_.R * inner_.apply(seen_inside(measurement), R);
  }

  [[nodiscard]] AugmentedStates::Matrix covariance(const AugmentedRowList& rows) const override {
    return inner_.covariance(seen_inside(rows));
  }

  geometry::Vec3 replace(const AugmentedRowList& rows, const AugmentedStates::Vector& shift,
                         const AugmentedStates::Matrix& covariance) override {
    return T_odom_inner_.R * inner_.replace(seen_inside(rows), shift, covariance);
  }

  void widen(double factor) override { inner_.widen(factor); }

  [[nodiscard]] std::optional<geometry::Vec3> degenerate_axis() const override;
  [[nodiscard]] int surfaces_between(const geometry::Vec3& p_odom_m,
                                     const geometry::Vec3& q_odom_m) const override;
  [[nodiscard]] geometry::Mat3 position_covariance() const override;

 private:
  [[nodiscard]] AugmentedMeasurement seen_inside(const AugmentedMeasurement& measurement) const;
  [[nodiscard]] AugmentedRowList seen_inside(const AugmentedRowList& rows) const;

  AugmentedFilter& inner_;
  geometry::SE3 T_imu_body_;
  geometry::SE3 T_odom_inner_;
  geometry::SE3 T_inner_imu_;  ///< at the last advance_to()
};

}  // namespace rali::odometry
