#include "rali/odometry/body_frame.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::odometry {
namespace {

using geometry::boxminus;
using geometry::boxplus;
using geometry::Mat6;
using geometry::SE3;
using geometry::so3_exp;
using geometry::Vec3;
using geometry::Vec6;

/// An odometry that returns the given result.
class Canned final : public Odometry {
 public:
  explicit Canned(const ScanResult& result) : result_(result) {}

  void add_imu(const sensor::ImuSample&) override {}

  ScanResult process(const sensor::LidarScan&, Executor&, FindingList&) override { return result_; }

  [[nodiscard]] Vec3 gravity_odom() const override { return {0.1, 0.0, -9.8}; }

  [[nodiscard]] geometry::Mat3 gravity_covariance() const override {
    return geometry::Mat3::Identity();
  }

  [[nodiscard]] std::uint64_t state_hash() const override { return 7; }

 private:
  const ScanResult& result_;
};

// The IMU is rotated by 90 degrees about z and mounted 40 cm behind and 30 cm beside the body.
const SE3 kBodyImu{so3_exp(Vec3(0.0, 0.0, M_PI / 2)), Vec3(-0.4, 0.3, 0.1)};

struct Fixture {
  ScanResult inner;
  std::unique_ptr<Odometry> outer = in_body_frame(std::make_unique<Canned>(inner), kBodyImu);
  SerialExecutor executor;
  FindingList findings;

  Fixture() { inner.state = TrackState::kGood; }

  ScanResult process() { return outer->process({}, executor, findings); }
};

TEST(BodyFrame, is_bypassed_when_imu_and_body_frames_coincide) {
  const ScanResult result;
  auto inner = std::make_unique<Canned>(result);
  const Odometry* raw = inner.get();
  EXPECT_EQ(in_body_frame(std::move(inner), SE3{}).get(), raw);
}

TEST(BodyFrame, starts_at_the_origin_heading_along_x_and_follows_the_body) {
  Fixture f;
  // The IMU's path in its own odom, which starts at the IMU's first pose.
  const auto body = [](double s) {
    return SE3{so3_exp(Vec3(0.0, 0.0, 0.3 * s)), Vec3(2.0 * s, 0.5 * s * s, 0.0)};
  };
  const SE3 T_inner_world = (body(0.0) * kBodyImu).inverse();
  for (const double s : {0.0, 0.5, 1.0, 3.0}) {
    f.inner.T_odom_body = T_inner_world * body(s) * kBodyImu;
    const SE3 seen = f.process().T_odom_body;
    EXPECT_LT(boxminus(seen, body(s)).norm(), 1e-12) << s;
  }
}

TEST(BodyFrame, anchors_odom_when_the_inner_odometry_stops_waiting) {
  Fixture f;
  f.inner.state = TrackState::kWaiting;
  f.inner.T_odom_body.p = Vec3(5.0, 5.0, 5.0);
  EXPECT_EQ(f.process().state, TrackState::kWaiting);
  f.inner.state = TrackState::kGood;  // only now is odom anchored
  EXPECT_LT(f.process().T_odom_body.p.norm(), 1e-12);
}

TEST(BodyFrame, velocity_is_that_of_the_body_origin) {
  Fixture f;
  static_cast<void>(f.process());
  // Turning on the spot about the body: the IMU moves, the body does not.
  const Vec3 w_body(0.0, 0.0, 2.0);
  const SE3 T_odom_body{};
  const SE3 T_inner_odom = kBodyImu.inverse();  // odom of Fixture: anchored at the first body
  f.inner.v_odom_mps = T_inner_odom.R * (T_odom_body.R * w_body.cross(kBodyImu.p));
  sensor::ImuSample sample;
  sample.gyro_radps = kBodyImu.R.transpose() * w_body;
  f.outer->add_imu(sample);
  EXPECT_LT(f.process().v_odom_mps.norm(), 1e-12);
}

TEST(BodyFrame, covariance_and_information_are_propagated_to_the_body_pose) {
  Fixture f;
  Rng rng(1, "body");
  f.inner.T_odom_body = {so3_exp(Vec3(0.1, -0.2, 1.0)), Vec3(3.0, 1.0, 0.5)};
  Mat6 A;
  for (int i = 0; i < 36; ++i) A.data()[i] = 0.1 * rng.normal();
  f.inner.covariance = A * A.transpose() + 1e-4 * Mat6::Identity();
  f.inner.lidar_information = f.inner.covariance.inverse();
  const ScanResult out = f.process();
  // Numerical Jacobian through the poses themselves.
  const SE3 inner_pose = f.inner.T_odom_body;
  Mat6 J;
  for (int k = 0; k < 6; ++k) {
    const Vec6 d = 1e-6 * Vec6::Unit(k);
    f.inner.T_odom_body = boxplus(inner_pose, d);
    const SE3 plus = f.process().T_odom_body;
    f.inner.T_odom_body = boxplus(inner_pose, -d);
    const SE3 minus = f.process().T_odom_body;
    J.col(k) = (boxminus(plus, out.T_odom_body) - boxminus(minus, out.T_odom_body)) / 2e-6;
  }
  const Mat6 expected = J * f.inner.covariance * J.transpose();
  EXPECT_LT((out.covariance - expected).norm(), 1e-6 * expected.norm());
  EXPECT_LT((out.lidar_information * out.covariance - Mat6::Identity()).norm(), 1e-6);
}

TEST(BodyFrame, transforms_planes_keyframes_and_gravity_into_the_body_odom) {
  Fixture f;
  f.inner.T_odom_body = {so3_exp(Vec3(0.0, 0.0, 0.7)), Vec3(1.0, 2.0, 0.0)};
  std::vector<degeneracy::PlaneEvidence> planes(1);
  const Vec3 x_inner(4.0, 5.0, 6.0);  // position of the plane's points
  planes[0].n_odom = Vec3::UnitX();
  planes[0].lever_odom_m = x_inner - f.inner.T_odom_body.p;
  f.inner.planes = planes;
  auto keyframe = std::make_shared<Keyframe>();
  keyframe->T_odom_body = f.inner.T_odom_body;
  keyframe->T_body_lidar = SE3{geometry::Mat3::Identity(), Vec3(0.1, 0.0, 0.0)};
  keyframe->cloud.x_m = {1.0F};
  keyframe->cloud.y_m = {2.0F};
  keyframe->cloud.z_m = {3.0F};
  f.inner.keyframe = keyframe;
  const ScanResult out = f.process();
  const SE3 T_odom_inner = out.T_odom_body * (f.inner.T_odom_body * kBodyImu.inverse()).inverse();
  EXPECT_LT((out.planes[0].n_odom - T_odom_inner.R * Vec3::UnitX()).norm(), 1e-12);
  EXPECT_LT((out.T_odom_body.p + out.planes[0].lever_odom_m - T_odom_inner * x_inner).norm(),
            1e-12);
  EXPECT_LT((f.outer->gravity_odom() - T_odom_inner.R * Vec3(0.1, 0.0, -9.8)).norm(), 1e-12);
  ASSERT_NE(out.keyframe, nullptr);
  // The point and the ray's origin keep their positions in the world.
  const Vec3 world = T_odom_inner * (f.inner.T_odom_body * Vec3(1.0, 2.0, 3.0));
  const KeyframeCloud& c = out.keyframe->cloud;
  const Vec3 seen = out.keyframe->T_odom_body * Vec3(c.x_m[0], c.y_m[0], c.z_m[0]);
  EXPECT_LT((seen - world).norm(), 1e-5);
  const SE3 lidar = out.keyframe->T_odom_body * out.keyframe->T_body_lidar;
  EXPECT_LT((lidar.p - T_odom_inner * (f.inner.T_odom_body * Vec3(0.1, 0.0, 0.0))).norm(), 1e-12);
}

TEST(ImuCalibration, expresses_the_lidar_pose_in_the_imu_frame) {
  sensor::Calibration c;
  c.T_body_imu = kBodyImu;
  c.T_body_lidar = SE3{so3_exp(Vec3(0.1, 0.2, 0.3)), Vec3(1.0, 0.0, 0.5)};
  const sensor::Calibration seen = imu_calibration(c);
  EXPECT_LT(boxminus(c.T_body_imu * seen.T_body_lidar, c.T_body_lidar).norm(), 1e-12);
  EXPECT_EQ(seen.T_body_imu.p, Vec3(Vec3::Zero()));
}

}  // namespace
}  // namespace rali::odometry
