#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "rali/odometry/robust/robust_odometry.hpp"
#include "rali/odometry/room_for_test.hpp"
#include "rali/odometry/side_filter_for_test.hpp"

namespace rali::odometry {

/// Drives through a world up to the end of a sweep; what comes between sweeps is up to the test.
struct Driven {
  TestRoom room;
  bool has_imu;
  std::unique_ptr<Odometry> odometry;
  SideFilter* filter = nullptr;
  FindingList findings;
  int sweeps = 0;
  int imu_samples = 0;
  Time t_end;

  Driven(const TestRoom& world, int sweeps_driven, bool with_imu,
         const OdometrySettings& settings = {})
      : room(world), has_imu(with_imu) {
    sensor::Calibration calibration;
    calibration.T_body_lidar = room.T_body_lidar;
    odometry = make_robust_odometry(settings, calibration, has_imu);
    filter = odometry->side_filter();
    while (sweeps < sweeps_driven) sweep();
  }

  ScanResult sweep() {
    SerialExecutor executor;
    const auto scan = room.scan(TestRoom::kSweep_s * sweeps++);
    imu_until(TestRoom::kSweep_s * sweeps);
    t_end = scan->t_end;
    return odometry->process(*scan, executor, findings);
  }

  /// The inertial data that the filter may have up to then.
  void imu_until(double t_s) {
    for (; has_imu && 0.005 * imu_samples <= t_s + 1e-9; ++imu_samples) {
      odometry->add_imu(room.imu(0.005 * imu_samples));
    }
  }

  [[nodiscard]] Moment now() const { return *filter->advance_to(t_end); }
};

/// Drives on while the accelerometer feels a push that the body does not.
inline ScanResult drive_pushed(Driven& driven, int sweeps, double push_mps2) {
  ScanResult result;
  for (int k = 0; k < sweeps; ++k) {
    const double until_s = TestRoom::kSweep_s * (driven.sweeps + 1);
    for (; 0.005 * driven.imu_samples <= until_s + 1e-9; ++driven.imu_samples) {
      sensor::ImuSample sample = driven.room.imu(0.005 * driven.imu_samples);
      sample.accel_mps2.x() += push_mps2;
      driven.odometry->add_imu(sample);
    }
    result = driven.sweep();
  }
  return result;
}

inline TestRoom small_room() {
  TestRoom room;
  room.rings = 8;
  room.columns = 150;
  return room;
}

/// Under way, its speed turned against odom, and found itself.
inline Driven under_way(bool has_imu) {
  TestRoom room = small_room();
  if (has_imu) return {room, 18, true};
  room.rest_s = -3.0;
  return {room, 5, false};
}

/// Straight on along x through a passage whose ends no ray reaches.
inline TestRoom tunnel() {
  TestRoom room;
  room.walls = {{-4000.0, -2.0, -1.0}, {4000.0, 2.5, 1.9}};
  room.pillars.clear();
  room.radius_m = 1e5;
  room.rings = 8;
  room.columns = 150;
  return room;
}

/// Rows that are the pose (6, boxplus), the velocity (3) and the side states themselves.
inline SideRowList unit_rows(const SideFilter& filter) {
  const int n = filter.side().size();
  SideMeasurement none;
  none.d_side = SideStates::Vector::Zero(n);
  SideRowList rows(static_cast<std::size_t>(DenseSideFilter::kOwn + n), none);
  for (int k = 0; k < DenseSideFilter::kOwn + n; ++k) {
    SideMeasurement& row = rows[static_cast<std::size_t>(k)];
    if (k < 6) {
      row.d_pose[k] = 1.0;
    } else if (k < DenseSideFilter::kOwn) {
      row.d_velocity[k - 6] = 1.0;
    } else {
      row.d_side[k - DenseSideFilter::kOwn] = 1.0;
    }
  }
  return rows;
}

/// The textbook with the same belief.
inline DenseSideFilter textbook(const Driven& driven) {
  DenseSideFilter out;
  out.now = driven.now();
  out.known = driven.filter->side();
  out.P = driven.filter->covariance(unit_rows(*driven.filter));
  return out;
}

/// What two filters believe is the same, to shares of how much they doubt it.
inline void expect_same(const Driven& driven, const DenseSideFilter& dense, double mean_share,
                        double covariance_share) {
  const Moment now = driven.now();
  const SideStates& side = driven.filter->side();
  ASSERT_EQ(side.size(), dense.known.size());
  const int size = DenseSideFilter::kOwn + side.size();
  Eigen::VectorXd apart(size);
  apart << geometry::boxminus(now.T_odom_body, dense.now.T_odom_body),
      now.v_odom_mps - dense.now.v_odom_mps, side.mean - dense.known.mean;
  const Eigen::MatrixXd P = driven.filter->covariance(unit_rows(*driven.filter));
  const Eigen::VectorXd sigma = dense.P.diagonal().cwiseMax(1e-12).cwiseSqrt();
  const Eigen::VectorXd inverse = sigma.cwiseInverse();
  EXPECT_LT((inverse.asDiagonal() * apart).cwiseAbs().maxCoeff(), mean_share);
  const Eigen::MatrixXd off = inverse.asDiagonal() * (P - dense.P) * inverse.asDiagonal();
  EXPECT_LT(off.cwiseAbs().maxCoeff(), covariance_share);
}

/// The map's own error in a prediction: in its variance, and nobody's to correct.
inline double map_error(const SideFilter& filter, const SideMeasurement& m) {
  return filter.variance(m) - filter.covariance(SideRowList{m})(0, 0);
}

/// A place (three side states) and a bias, as somebody who measures ranges has them.
inline void add_place_and_bias(SideFilter& filter) {
  SideStates::Vector place = geometry::Vec3(9.0, 2.0, 0.5);
  SideStates::Matrix doubt = geometry::Vec3(0.09, 0.25, 0.01).asDiagonal();
  doubt(0, 1) = doubt(1, 0) = 0.05;
  ASSERT_EQ(filter.add_side(place, doubt, {}), 0);
  SideStates::Vector bias(1);
  bias[0] = 0.1;
  SideStates::Matrix bias_doubt(1, 1);
  bias_doubt(0, 0) = 0.01;
  ASSERT_EQ(filter.add_side(bias, bias_doubt, {}), 3);
}

}  // namespace rali::odometry
