#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "rali/odometry/augmented_filter_for_test.hpp"
#include "rali/odometry/robust/robust_odometry.hpp"
#include "rali/odometry/room_for_test.hpp"

namespace rali::odometry {

/// Drives through a world up to the end of a scan; the test adds events between scans.
struct Driven {
  TestRoom room;
  bool has_imu;
  std::unique_ptr<Odometry> odometry;
  AugmentedFilter* filter = nullptr;
  FindingList findings;
  int scans = 0;
  int imu_samples = 0;
  Time t_end;

  Driven(const TestRoom& world, int scans_driven, bool with_imu,
         const OdometrySettings& settings = {})
      : room(world), has_imu(with_imu) {
    sensor::Calibration calibration;
    calibration.T_body_lidar = room.T_body_lidar;
    odometry = make_robust_odometry(settings, calibration, has_imu);
    filter = odometry->augmented_filter();
    while (scans < scans_driven) scan();
  }

  ScanResult scan() {
    SerialExecutor executor;
    const auto scan = room.scan(TestRoom::kScan_s * scans++);
    imu_until(TestRoom::kScan_s * scans);
    t_end = scan->t_end;
    return odometry->process(*scan, executor, findings);
  }

  /// Adds the inertial data up to this time.
  void imu_until(double t_s) {
    for (; has_imu && 0.005 * imu_samples <= t_s + 1e-9; ++imu_samples) {
      odometry->add_imu(room.imu(0.005 * imu_samples));
    }
  }

  [[nodiscard]] Moment now() const { return *filter->advance_to(t_end); }
};

/// Drives on while the accelerometer measures a force that does not act on the body.
inline ScanResult drive_pushed(Driven& driven, int scans, double push_mps2) {
  ScanResult result;
  for (int k = 0; k < scans; ++k) {
    const double until_s = TestRoom::kScan_s * (driven.scans + 1);
    for (; 0.005 * driven.imu_samples <= until_s + 1e-9; ++driven.imu_samples) {
      sensor::ImuSample sample = driven.room.imu(0.005 * driven.imu_samples);
      sample.accel_mps2.x() += push_mps2;
      driven.odometry->add_imu(sample);
    }
    result = driven.scan();
  }
  return result;
}

inline TestRoom small_room() {
  TestRoom room;
  room.rings = 8;
  room.columns = 150;
  return room;
}

/// A driving vehicle with its velocity turned against odom, and the filter initialised.
inline Driven under_way(bool has_imu) {
  TestRoom room = small_room();
  if (has_imu) return {room, 18, true};
  room.rest_s = -3.0;
  return {room, 5, false};
}

/// Straight along x through a tunnel whose ends no ray reaches.
inline TestRoom tunnel() {
  TestRoom room;
  room.walls = {{-4000.0, -2.0, -1.0}, {4000.0, 2.5, 1.9}};
  room.pillars.clear();
  room.radius_m = 1e5;
  room.rings = 8;
  room.columns = 150;
  return room;
}

/// Rows for the pose (6, boxplus), the velocity (3) and the augmented states themselves.
inline AugmentedRowList unit_rows(const AugmentedFilter& filter) {
  const int n = filter.augmented().size();
  AugmentedMeasurement none;
  none.d_augmented = AugmentedStates::Vector::Zero(n);
  AugmentedRowList rows(static_cast<std::size_t>(DenseAugmentedFilter::kOwn + n), none);
  for (int k = 0; k < DenseAugmentedFilter::kOwn + n; ++k) {
    AugmentedMeasurement& row = rows[static_cast<std::size_t>(k)];
    if (k < 6) {
      row.d_pose[k] = 1.0;
    } else if (k < DenseAugmentedFilter::kOwn) {
      row.d_velocity[k - 6] = 1.0;
    } else {
      row.d_augmented[k - DenseAugmentedFilter::kOwn] = 1.0;
    }
  }
  return rows;
}

/// The reference filter with the same mean and covariance.
inline DenseAugmentedFilter textbook(const Driven& driven) {
  DenseAugmentedFilter out;
  out.now = driven.now();
  out.known = driven.filter->augmented();
  out.P = driven.filter->covariance(unit_rows(*driven.filter));
  return out;
}

/// Two filters have the same estimate, up to the given fractions of their sigmas.
inline void expect_same(const Driven& driven, const DenseAugmentedFilter& dense,
                        double mean_fraction, double covariance_fraction) {
  const Moment now = driven.now();
  const AugmentedStates& augmented = driven.filter->augmented();
  ASSERT_EQ(augmented.size(), dense.known.size());
  const int size = DenseAugmentedFilter::kOwn + augmented.size();
  Eigen::VectorXd apart(size);
  apart << geometry::boxminus(now.T_odom_body, dense.now.T_odom_body),
      now.v_odom_mps - dense.now.v_odom_mps, augmented.mean - dense.known.mean;
  const Eigen::MatrixXd P = driven.filter->covariance(unit_rows(*driven.filter));
  const Eigen::VectorXd sigma = dense.P.diagonal().cwiseMax(1e-12).cwiseSqrt();
  const Eigen::VectorXd inverse = sigma.cwiseInverse();
  EXPECT_LT((inverse.asDiagonal() * apart).cwiseAbs().maxCoeff(), mean_fraction);
  const Eigen::MatrixXd off = inverse.asDiagonal() * (P - dense.P) * inverse.asDiagonal();
  EXPECT_LT(off.cwiseAbs().maxCoeff(), covariance_fraction);
}

/// The map's own error in a prediction: part of its variance, but never corrected.
inline double map_error(const AugmentedFilter& filter, const AugmentedMeasurement& m) {
  return filter.variance(m) - filter.covariance(AugmentedRowList{m})(0, 0);
}

/// A landmark (three augmented states) and a bias, as added by a user that measures ranges.
inline void add_landmark_and_bias(AugmentedFilter& filter) {
  AugmentedStates::Vector place = geometry::Vec3(9.0, 2.0, 0.5);
  AugmentedStates::Matrix uncertainty = geometry::Vec3(0.09, 0.25, 0.01).asDiagonal();
  uncertainty(0, 1) = uncertainty(1, 0) = 0.05;
  ASSERT_EQ(filter.add_states(place, uncertainty, {}), 0);
  AugmentedStates::Vector bias(1);
  bias[0] = 0.1;
  AugmentedStates::Matrix bias_uncertainty(1, 1);
  bias_uncertainty(0, 0) = 0.01;
  ASSERT_EQ(filter.add_states(bias, bias_uncertainty, {}), 3);
}

}  // namespace rali::odometry
