#pragma once

#include "rali/odometry/side_filter.hpp"

namespace rali::odometry {

/// d(boxplus of the body) / d(boxplus of the IMU) where odom is turned by R_odom_inner.
[[nodiscard]] geometry::Mat6 body_jacobian(const geometry::SE3& T_inner_imu,
                                           const geometry::SE3& T_imu_body,
                                           const geometry::Mat3& R_odom_inner);

/// A filter that runs in the frame of the IMU, as seen from the body: poses, derivatives and
/// shifts are those of the body in its own odom. The side states are the same numbers.
class BodySideFilter final : public SideFilter {
 public:
  BodySideFilter(SideFilter& inner, const geometry::SE3& T_imu_body)
      : inner_(inner), T_imu_body_(T_imu_body) {}

  void set_odom(const geometry::SE3& T_odom_inner) { T_odom_inner_ = T_odom_inner; }

  [[nodiscard]] std::optional<Moment> advance_to(Time t) override;

  [[nodiscard]] const SideStates& side() const override { return inner_.side(); }

  int add_side(const SideStates::Vector& mean, const SideStates::Matrix& covariance,
               const SideRowList& rows) override {
    return inner_.add_side(mean, covariance, seen_inside(rows));
  }

  void remove_side(int first, int n) override { inner_.remove_side(first, n); }

  void walk_side(int index, double variance) override { inner_.walk_side(index, variance); }

  [[nodiscard]] double variance(const SideMeasurement& measurement) const override {
    return inner_.variance(seen_inside(measurement));
  }

  geometry::Vec3 apply(const SideMeasurement& measurement, double R) override {
    return T_odom_inner_.R * inner_.apply(seen_inside(measurement), R);
  }

  [[nodiscard]] SideStates::Matrix covariance(const SideRowList& rows) const override {
    return inner_.covariance(seen_inside(rows));
  }

  geometry::Vec3 replace(const SideRowList& rows, const SideStates::Vector& shift,
                         const SideStates::Matrix& covariance) override {
    return T_odom_inner_.R * inner_.replace(seen_inside(rows), shift, covariance);
  }

  void widen(double factor) override { inner_.widen(factor); }

  [[nodiscard]] std::optional<geometry::Vec3> blind_axis() const override;
  [[nodiscard]] int surfaces_between(const geometry::Vec3& p_odom_m,
                                     const geometry::Vec3& q_odom_m) const override;
  [[nodiscard]] geometry::Mat3 position_covariance() const override;

 private:
  [[nodiscard]] SideMeasurement seen_inside(const SideMeasurement& measurement) const;
  [[nodiscard]] SideRowList seen_inside(const SideRowList& rows) const;

  SideFilter& inner_;
  geometry::SE3 T_imu_body_;
  geometry::SE3 T_odom_inner_;
  geometry::SE3 T_inner_imu_;  ///< at the last advance_to()
};

}  // namespace rali::odometry
