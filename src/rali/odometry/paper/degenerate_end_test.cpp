#include <algorithm>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "rali/odometry/paper/paper_odometry.hpp"
#include "rali/odometry/paper/testing/synthetic_room.hpp"

namespace rali::odometry {
namespace {

using geometry::Vec3;

/// Reports the first scans as degenerate, and records the scans that became keyframes.
class DegenerateAtFirst final : public KeyframeCorrector {
 public:
  explicit DegenerateAtFirst(int scans) : scans_(scans) {}

  std::optional<Vec3> degenerate_direction(std::span<const Vec3> /*normals_body*/,
                                           const Vec3& /*up_body*/) const override {
    return seen_++ < scans_ ? std::optional<Vec3>(Vec3::UnitX()) : std::nullopt;
  }

  std::optional<KeyframeMove> at_keyframe(const ScanResult& /*scan*/,
                                          const KeyframeInertia& /*inertia*/) override {
    keyframes.push_back(seen_);
    return std::nullopt;
  }

  std::vector<int> keyframes;

 private:
  int scans_;
  mutable int seen_ = 0;
};

/// The scans that became keyframes within four seconds.
std::vector<int> keyframes_of(int degenerate_scans) {
  paper::testing::Room room;
  paper::testing::Drive drive;
  paper::testing::Imu imu;
  paper::testing::Lidar lidar;
  lidar.rings = 32;
  lidar.columns = 450;
  OdometrySettings settings;
  settings.paper.keyframe_s = 1.0;
  sensor::Calibration calibration;
  calibration.T_body_lidar = lidar.T_body_lidar;
  calibration.T_body_imu = imu.T_body_imu;
  const std::unique_ptr<Odometry> odometry = make_paper_odometry(settings, calibration, true);
  DegenerateAtFirst corrector(degenerate_scans);
  odometry->correct_keyframes_by(&corrector);
  Rng rng(1);
  SerialExecutor executor;
  FindingList findings;
  double imu_s = 0.0;
  for (double t_s = 0.1; t_s < 4.0; t_s += 0.1) {
    for (; imu_s <= t_s + 0.0051; imu_s += 0.005) {
      odometry->add_imu(imu.sample(drive, imu_s, rng));
    }
    odometry->process(paper::testing::scan(room, drive, lidar, t_s, rng), executor, findings);
  }
  return corrector.keyframes;
}

// Keyframes of the stretch are a second apart: without one at its end the ranges since the last of
// them would never be used.
TEST(PaperOdometry, makes_a_keyframe_where_a_degenerate_stretch_ends) {
  constexpr int kDegenerate = 24;
  const std::vector<int> ends = keyframes_of(kDegenerate);
  const std::vector<int> goes_on = keyframes_of(1000);
  EXPECT_EQ(std::count(ends.begin(), ends.end(), kDegenerate + 1), 1);
  EXPECT_EQ(std::count(goes_on.begin(), goes_on.end(), kDegenerate + 1), 0);
}

}  // namespace
}  // namespace rali::odometry
