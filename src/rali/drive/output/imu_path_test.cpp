#include "rali/drive/output/imu_path.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

using geometry::Vec3;

constexpr double kRadius_m = 5.0, kTurn_radps = 0.8;
const geometry::SE3 kBodyImu{geometry::rotation_from_rpy(0.0, 0.1, 1.2), {0.3, -0.2, 0.1}};

/// The IMU moves in a circle and shakes up and down at 8 Hz, far above what scans resolve.
geometry::SE3 imu_at(double t_s) {
  const double yaw = kTurn_radps * t_s;
  geometry::SE3 T;
  T.R = geometry::rotation_from_rpy(0.0, 0.0, yaw);
  T.p = Vec3(kRadius_m * std::sin(yaw), kRadius_m * (1.0 - std::cos(yaw)),
             0.005 * std::sin(50.0 * t_s));
  return T;
}

sensor::ImuSample sample_at(double t_s, const Vec3& gyro_bias_radps) {
  constexpr double kStep_s = 1e-4;
  const Vec3 a = (imu_at(t_s + kStep_s).p - 2.0 * imu_at(t_s).p + imu_at(t_s - kStep_s).p) /
                 (kStep_s * kStep_s);
  sensor::ImuSample sample;
  sample.t = Time::from_s(t_s);
  sample.gyro_radps = Vec3(0.0, 0.0, kTurn_radps) + gyro_bias_radps;
  sample.accel_mps2 = imu_at(t_s).R.transpose() * (a + Vec3(0.0, 0.0, 9.80665));
  return sample;
}

std::vector<PoseRecord> poses_until(double end_s) {
  std::vector<PoseRecord> poses;
  for (int k = 0; 0.1 * k < end_s; ++k) {
    PoseRecord pose;
    pose.t = Time::from_s(0.1 * k);
    pose.T_local_body = imu_at(0.1 * k) * kBodyImu.inverse();
    poses.push_back(pose);
  }
  return poses;
}

std::vector<sensor::ImuSample> samples_until(double end_s, const Vec3& gyro_bias_radps) {
  std::vector<sensor::ImuSample> samples;
  for (int i = 1; 0.0025 * i + 0.001 < end_s; ++i) {
    samples.push_back(sample_at(0.0025 * i + 0.001, gyro_bias_radps));
  }
  return samples;
}

struct Worst {
  double position_m = 0.0, rotation_rad = 0.0;
  std::size_t poses = 0;
};

Worst worst_of(const std::vector<PoseRecord>& poses,
               const std::vector<sensor::ImuSample>& samples) {
  Worst worst;
  const Status done =
      imu_rate_poses(poses, {}, samples, kBodyImu, [&](const io::StampedPose& pose) {
        const geometry::SE3 error = imu_at(pose.t.s()).inverse() * (pose.T * kBodyImu);
        worst.position_m = std::max(worst.position_m, error.p.norm());
        worst.rotation_rad = std::max(worst.rotation_rad, geometry::so3_log(error.R).norm());
        ++worst.poses;
        return Status{};
      });
  EXPECT_TRUE(done);
  return worst;
}

// Straight lines between the scans would miss the shaking by 5 mm and the arc by 1 mm.
TEST(ImuPath, follows_the_motion_between_scans) {
  const auto samples = samples_until(2.03, Vec3(0.02, -0.01, 0.03));
  const Worst worst = worst_of(poses_until(2.05), samples);
  const auto inside = std::count_if(samples.begin(), samples.end(),
                                    [](const sensor::ImuSample& s) { return s.t.s() <= 2.0; });
  EXPECT_EQ(static_cast<std::ptrdiff_t>(worst.poses), inside);
  EXPECT_LT(worst.position_m, 0.0006);
  EXPECT_LT(worst.rotation_rad, 1e-4) << "a bias of the gyro is spread over the interval";
}

TEST(ImuPath, omits_diverged_intervals_and_samples_outside_the_scans) {
  auto poses = poses_until(1.05);
  poses[5].quality = vehicle::PoseQuality::kDiverged;
  const auto samples = samples_until(3.0, Vec3::Zero());
  const Worst worst = worst_of(poses, samples);
  std::size_t inside = 0;
  for (const sensor::ImuSample& sample : samples) {
    const double t = sample.t.s();
    inside += t <= 0.4 || (t > 0.6 && t <= 1.0);
  }
  EXPECT_EQ(worst.poses, inside);
}

TEST(ImuPath, interpolates_where_samples_are_missing) {
  auto samples = samples_until(0.35, Vec3::Zero());
  std::erase_if(samples,
                [](const sensor::ImuSample& s) { return s.t.s() > 0.105 && s.t.s() < 0.295; });
  std::vector<PoseRecord> poses = poses_until(0.45);
  poses.erase(poses.begin() + 2);  // one interval from 0.1 to 0.3 s
  const Worst worst = worst_of(poses, samples);
  EXPECT_LT(worst.position_m, 0.03) << "never farther off than a straight line";
}

}  // namespace
}  // namespace rali::drive
