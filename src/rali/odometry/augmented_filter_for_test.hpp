#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/QR>

#include "rali/geometry/se3.hpp"
#include "rali/odometry/augmented_filter.hpp"

namespace rali::odometry {

/// Reference implementation: a filter of pose, velocity and augmented states with one dense
/// covariance, to test users and implementations of AugmentedFilter. Moves at constant velocity.
struct DenseAugmentedFilter final : AugmentedFilter {
  static constexpr int kOwn = 9;  ///< rotation, position, velocity

  Moment now;
  AugmentedStates known;
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(kOwn, kOwn);
  std::optional<geometry::Vec3> axis;
  int surfaces = 0;               ///< between any two points
  std::vector<double> walls_x_m;  ///< and walls across x
  std::vector<double> walls_y_m;  ///< and walls along x
  bool found_itself = true;
  double late_max_s = 0.1;
  // Records of the calls.
  std::vector<Time> asked;
  std::vector<AugmentedMeasurement> applied;
  std::vector<double> applied_R;
  double widened = 1.0;
  int replaced = 0;  ///< calls

  std::optional<Moment> advance_to(Time t) override {
    asked.push_back(t);
    const double dt_s = (t - now.t).s();
    if (!found_itself || dt_s < -late_max_s) return std::nullopt;
    if (dt_s > 0.0) {
      now.T_odom_body.p += dt_s * now.v_odom_mps;
      now.t = t;
      return now;
    }
    Moment then = now;
    then.T_odom_body.p += dt_s * now.v_odom_mps;
    then.t = t;
    return then;
  }

  [[nodiscard]] const AugmentedStates& augmented() const override { return known; }

  int add_states(const AugmentedStates::Vector& mean, const AugmentedStates::Matrix& covariance,
                 const AugmentedRowList& rows) override {
    const int first = known.size();
    const auto n = static_cast<int>(mean.size());
    if (first + n > AugmentedStates::kMax) return -1;
    // New = H old + noise, as one linear map of old and new states.
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(P.rows() + n, P.cols());
    A.topRows(P.rows()).setIdentity();
    if (!rows.empty()) A.bottomRows(n) = stacked(rows);
    P = (A * P * A.transpose()).eval();
    P.bottomRightCorner(n, n) += covariance;
    known.mean.conservativeResize(first + n);
    known.mean.tail(n) = mean;
    fraction();
    return first;
  }

  void remove_states(int first, int n) override {
    std::vector<int> kept;
    for (int k = 0; k < P.rows(); ++k) {
      if (k < kOwn + first || k >= kOwn + first + n) kept.push_back(k);
    }
    P = P(kept, kept).eval();
    const AugmentedStates::Vector mean = known.mean;
    known.mean.resize(static_cast<int>(kept.size()) - kOwn);
    for (int k = 0; k < known.size(); ++k) known.mean[k] = mean[k < first ? k : k + n];
    fraction();
  }

  void walk_side(int index, double variance_added) override {
    P(kOwn + index, kOwn + index) += variance_added;
    fraction();
  }

  [[nodiscard]] double variance(const AugmentedMeasurement& m) const override {
    const Eigen::RowVectorXd H = row(m);
    return (H * P * H.transpose()).value();
  }

  geometry::Vec3 apply(const AugmentedMeasurement& m, double R) override {
    applied.push_back(m);
    applied_R.push_back(R);
    const Eigen::RowVectorXd H = row(m);
    const Eigen::VectorXd PHt = P * H.transpose();
    const double S = (H * PHt).value() + R;
    Eigen::VectorXd K = PHt / S;
    if (m.considered >= 0) {
      K.segment<3>(kOwn + m.considered) = (m.estimates * K.segment<3>(kOwn + m.considered)).eval();
    }
    // (1 - KH) P (1 - KH)' + K R K', for any gain.
    const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(P.rows(), P.cols()) - K * H;
    P = (A * P * A.transpose() + R * K * K.transpose()).eval();
    const geometry::Vec6 shift = K.head<6>() * m.residual;
    now.T_odom_body = geometry::boxplus(now.T_odom_body, shift);
    now.v_odom_mps += K.segment<3>(6) * m.residual;
    known.mean += K.tail(known.size()) * m.residual;
    fraction();
    return shift.tail<3>();
  }

  [[nodiscard]] AugmentedStates::Matrix covariance(const AugmentedRowList& rows) const override {
    const Eigen::MatrixXd H = stacked(rows);
    return H * P * H.transpose();
  }

  geometry::Vec3 replace(const AugmentedRowList& rows, const AugmentedStates::Vector& shift,
                         const AugmentedStates::Matrix& covariance_new) override {
    // In coordinates that start with the rows: their block is replaced, and the rest follows by
    // regression on them.
    const Eigen::MatrixXd H = stacked(rows);
    const Eigen::MatrixXd S = H * P * H.transpose();
    const Eigen::MatrixXd K =
        P * H.transpose() * S.completeOrthogonalDecomposition().pseudoInverse();
    const Eigen::MatrixXd rest = P - K * S * K.transpose();
    P = rest + K * covariance_new * K.transpose();
    const Eigen::VectorXd moved = K * shift;
    const geometry::Vec6 pose = moved.head<6>();
    now.T_odom_body = geometry::boxplus(now.T_odom_body, pose);
    now.v_odom_mps += moved.segment<3>(6);
    known.mean += moved.tail(known.size());
    ++replaced;
    fraction();
    return pose.tail<3>();
  }

  void widen(double factor) override { widened *= factor; }

  [[nodiscard]] std::optional<geometry::Vec3> degenerate_axis() const override { return axis; }

  [[nodiscard]] int surfaces_between(const geometry::Vec3& p,
                                     const geometry::Vec3& q) const override {
    const auto count = [&](const std::vector<double>& walls_m, int k) {
      return std::count_if(walls_m.begin(), walls_m.end(),
                           [&](double wall_m) { return (p[k] - wall_m) * (q[k] - wall_m) < 0.0; });
    };
    return surfaces + static_cast<int>(count(walls_x_m, 0) + count(walls_y_m, 1));
  }

  [[nodiscard]] geometry::Mat3 position_covariance() const override { return P.block<3, 3>(3, 3); }

  [[nodiscard]] Eigen::MatrixXd stacked(const AugmentedRowList& rows) const {
    Eigen::MatrixXd H(static_cast<int>(rows.size()), P.cols());
    for (int k = 0; k < H.rows(); ++k) H.row(k) = row(rows[static_cast<std::size_t>(k)]);
    return H;
  }

  [[nodiscard]] Eigen::RowVectorXd row(const AugmentedMeasurement& m) const {
    Eigen::RowVectorXd H = Eigen::RowVectorXd::Zero(P.cols());
    H.head<6>() = m.d_pose;
    H.segment<3>(6) = m.d_velocity;
    if (m.d_augmented.size() > 0) H.tail(m.d_augmented.size()) = m.d_augmented.transpose();
    return H;
  }

 private:
  void fraction() { known.covariance = P.bottomRightCorner(known.size(), known.size()); }
};

}  // namespace rali::odometry
