#include "rali/odometry/body_frame.hpp"

#include <cmath>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "rali/odometry/body_augmented_filter.hpp"

namespace rali::odometry {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

namespace {

class BodyFrameOdometry final : public Odometry {
 public:
  BodyFrameOdometry(std::unique_ptr<Odometry> inner, const SE3& T_body_imu)
      : inner_(std::move(inner)), T_imu_body_(T_body_imu.inverse()) {
    if (AugmentedFilter* augmented = inner_->augmented_filter())
      augmented_.emplace(*augmented, T_imu_body_);
  }

  void add_imu(const sensor::ImuSample& sample) override {
    omega_imu_radps_ = sample.gyro_radps;
    inner_->add_imu(sample);
  }

  ScanResult process(const sensor::LidarScan& scan, Executor& executor,
                     FindingList& findings) override;

  [[nodiscard]] Vec3 gravity_odom() const override {
    return T_odom_inner_.R * inner_->gravity_odom();
  }

  [[nodiscard]] Mat3 gravity_covariance() const override {
    return T_odom_inner_.R * inner_->gravity_covariance() * T_odom_inner_.R.transpose();
  }

  void finish(FindingList& findings) override { inner_->finish(findings); }

  [[nodiscard]] std::uint64_t state_hash() const override { return inner_->state_hash(); }

  [[nodiscard]] AugmentedFilter* augmented_filter() override {
    return augmented_ && anchored_ ? &*augmented_ : nullptr;
  }

 private:
  void anchor(const SE3& T_inner_body);
  [[nodiscard]] std::shared_ptr<const Keyframe> converted(const Keyframe& in, const Mat6& J) const;

  std::unique_ptr<Odometry> inner_;
  std::optional<BodyAugmentedFilter> augmented_;
  SE3 T_imu_body_;
  SE3 T_odom_inner_;  ///< yaw and translation only: keeps z up
  bool anchored_ = false;
  Vec3 omega_imu_radps_ = Vec3::Zero();
  std::vector<degeneracy::PlaneEvidence> planes_;
  std::vector<Vec3> normals_;
};

/// Sets odom so that the body starts at its origin, heading along x.
void BodyFrameOdometry::anchor(const SE3& T_inner_body) {
  const double yaw = std::atan2(T_inner_body.R(1, 0), T_inner_body.R(0, 0));
  T_odom_inner_.R = geometry::so3_exp(Vec3(0.0, 0.0, -yaw));
  T_odom_inner_.p = -(T_odom_inner_.R * T_inner_body.p);
  if (augmented_) augmented_->set_odom(T_odom_inner_);
  anchored_ = true;
}

ScanResult BodyFrameOdometry::process(const sensor::LidarScan& scan, Executor& executor,
                                      FindingList& findings) {
  ScanResult out = inner_->process(scan, executor, findings);
  if (out.state == TrackState::kWaiting) return out;
  const SE3 T_inner_imu = out.T_odom_body;
  if (!anchored_) anchor(T_inner_imu * T_imu_body_);
  const Mat3& R = T_odom_inner_.R;
  const Vec3 lever_inner = T_inner_imu.R * T_imu_body_.p;  // from the IMU to the body
  const Mat6 J = body_jacobian(T_inner_imu, T_imu_body_, R);
  const Mat6 J_inverse = J.inverse();
  out.T_odom_body = T_odom_inner_ * T_inner_imu * T_imu_body_;
  out.T_odom_body_predicted = T_odom_inner_ * out.T_odom_body_predicted * T_imu_body_;
  out.T_last_predicted = T_imu_body_.inverse() * out.T_last_predicted * T_imu_body_;
  out.v_odom_mps = R * (out.v_odom_mps + T_inner_imu.R * omega_imu_radps_.cross(T_imu_body_.p));
  out.covariance = J * out.covariance * J.transpose();
  out.lidar_information = J_inverse.transpose() * out.lidar_information * J_inverse;
  planes_.assign(out.planes.begin(), out.planes.end());
  for (degeneracy::PlaneEvidence& plane : planes_) {
    plane.n_odom = R * plane.n_odom;
    plane.lever_odom_m = R * (plane.lever_odom_m - lever_inner);
    plane.normal_covariance = R * plane.normal_covariance * R.transpose();
  }
  out.planes = planes_;
  normals_.assign(out.feature_normals_body.begin(), out.feature_normals_body.end());
  for (Vec3& n : normals_) n = T_imu_body_.R.transpose() * n;
  out.feature_normals_body = normals_;
  if (out.directions) {
    for (degeneracy::DirectionInfo& d : *out.directions) d.direction_odom = R * d.direction_odom;
  }
  if (out.keyframe) out.keyframe = converted(*out.keyframe, J);
  return out;
}

std::shared_ptr<const Keyframe> BodyFrameOdometry::converted(const Keyframe& in,
                                                             const Mat6& J) const {
  auto out = std::make_shared<Keyframe>(in);
  const SE3 T_body_imu = T_imu_body_.inverse();
  out->T_odom_body = T_odom_inner_ * in.T_odom_body * T_imu_body_;
  out->covariance = J * in.covariance * J.transpose();
  out->T_previous_this = T_body_imu * in.T_previous_this * T_imu_body_;
  const Mat6 J_relative = body_jacobian(in.T_previous_this, T_imu_body_, T_body_imu.R).inverse();
  out->information_relative = J_relative.transpose() * in.information_relative * J_relative;
  out->T_body_lidar = T_body_imu * in.T_body_lidar;
  const Eigen::Matrix3f R = T_body_imu.R.cast<float>();
  const Eigen::Vector3f p = T_body_imu.p.cast<float>();
  KeyframeCloud& c = out->cloud;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const Eigen::Vector3f q = R * Eigen::Vector3f(c.x_m[i], c.y_m[i], c.z_m[i]) + p;
    c.x_m[i] = q.x();
    c.y_m[i] = q.y();
    c.z_m[i] = q.z();
  }
  return out;
}

}  // namespace

std::unique_ptr<Odometry> in_body_frame(std::unique_ptr<Odometry> inner, const SE3& T_body_imu) {
  if (T_body_imu.R.isIdentity(0.0) && T_body_imu.p.isZero(0.0)) return inner;
  return std::make_unique<BodyFrameOdometry>(std::move(inner), T_body_imu);
}

sensor::Calibration imu_calibration(const sensor::Calibration& calibration) {
  sensor::Calibration out = calibration;
  out.T_body_lidar = calibration.T_body_imu.inverse() * calibration.T_body_lidar;
  out.T_body_imu = SE3{};
  return out;
}

}  // namespace rali::odometry
