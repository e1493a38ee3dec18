#include "rali/odometry/paper/paper_odometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/odometry/paper/testing/synthetic_room.hpp"

namespace rali::odometry {
namespace {

using geometry::SE3;
using geometry::Vec3;
using paper::testing::Drive;
using paper::testing::Imu;
using paper::testing::Lidar;
using paper::testing::Room;
using paper::testing::scan;

Lidar coarse_lidar() {
  Lidar lidar;
  lidar.rings = 32;  // with 16 the floor yields no feature (finding F2)
  lidar.columns = 450;
  return lidar;
}

struct Bench {
  Room room;
  Drive drive;
  Lidar lidar = coarse_lidar();
  Imu imu;
  OdometrySettings settings;
  bool has_imu = true;
  bool has_rings = true;
  double end_s = 5.0;
  std::uint64_t seed = 1;
};

struct Track {
  double worst_m = 0.0;
  double worst_deg = 0.0;
  double worst_mps = 0.0;
  int scans = 0;
  int good = 0;
  int keyframes = 0;
  int iterations = 0;
  std::size_t normals = 0;
  ScanResult last;
  FindingList findings;
  std::uint64_t hash = 0;
};

std::unique_ptr<Odometry> odometry_of(const Bench& b) {
  sensor::Calibration calibration;
  calibration.T_body_lidar = b.lidar.T_body_lidar;
  calibration.T_body_imu = b.imu.T_body_imu;
  return make_paper_odometry(b.settings, calibration, b.has_imu);
}

void judge(Track& track, const Bench& b, double t_s, const ScanResult& r) {
  const SE3 truth = b.drive.pose(t_s);
  ++track.scans;
  track.good += r.state == TrackState::kGood ? 1 : 0;
  track.keyframes += r.keyframe ? 1 : 0;
  track.iterations += r.iterations;
  track.normals += r.feature_normals_body.size();
  track.worst_m = std::max(track.worst_m, (r.T_odom_body.p - truth.p).norm());
  const double rad = geometry::so3_log(truth.R.transpose() * r.T_odom_body.R).norm();
  track.worst_deg = std::max(track.worst_deg, rad * 180.0 / std::numbers::pi);
  const Vec3 v = (b.drive.pose(t_s + 1e-4).p - b.drive.pose(t_s - 1e-4).p) / 2e-4;
  track.worst_mps = std::max(track.worst_mps, (r.v_odom_mps - v).norm());
}

Track run(const Bench& b) {
  Rng rng(b.seed);
  const auto odometry = odometry_of(b);
  SerialExecutor executor;
  Track track;
  double imu_s = 0.0;
  for (double t_s = 0.1; t_s < b.end_s; t_s += 0.1) {
    for (; b.has_imu && imu_s <= t_s + 0.0051; imu_s += 0.005) {
      odometry->add_imu(b.imu.sample(b.drive, imu_s, rng));
    }
    sensor::LidarScan scan = paper::testing::scan(b.room, b.drive, b.lidar, t_s, rng);
    scan.has_rings = b.has_rings;
    if (!b.has_rings) std::fill(scan.ring.begin(), scan.ring.end(), std::uint16_t{0});
    const ScanResult r = odometry->process(scan, executor, track.findings);
    if (r.state == TrackState::kWaiting) continue;
    judge(track, b, t_s, r);
    track.last = r;
    track.last.feature_normals_body = {};
    track.last.planes = {};
  }
  track.hash = odometry->state_hash();
  std::printf(
      "[   DATA   ] %d scans: worst %.4f m, %.3f deg, %.3f m/s, %.1f iterations, %d keyframes\n",
      track.scans, track.worst_m, track.worst_deg, track.worst_mps,
      track.iterations / std::max(1.0, static_cast<double>(track.scans)), track.keyframes);
  return track;
}

bool has_finding(const FindingList& findings, const std::string& id) {
  return std::any_of(findings.begin(), findings.end(),
                     [&](const Finding& f) { return f.id == id; });
}

TEST(PaperOdometry, follows_a_drive_in_a_room_within_4_cm) {
  Bench b;
  b.settings.paper.deskew = PaperDeskew::kFull;
  const Track track = run(b);
  EXPECT_GT(track.scans, 35);
  EXPECT_EQ(track.good, track.scans);
  EXPECT_LT(track.worst_m, 0.04);
  EXPECT_LT(track.worst_deg, 0.5);
  EXPECT_LT(track.worst_mps, 0.4);
  EXPECT_GE(track.keyframes, 1);
  EXPECT_GT(track.normals / static_cast<std::size_t>(track.scans), 200U);
  EXPECT_TRUE(track.findings.empty());
}

/// Moves the map and the pose at one keyframe.
struct MoveOnce final : KeyframeCorrector {
  Vec3 shift_m{0.3, -0.2, 0.1};
  int at = 1, asked = 0;
  std::vector<SE3> seen;

  // Keyframes by time, without a prior along the axis: a vertical one is never used for that.
  std::optional<Vec3> degenerate_direction(std::span<const Vec3>, const Vec3&) const override {
    return Vec3::UnitZ();
  }

  std::optional<KeyframeMove> at_keyframe(const ScanResult& scan,
                                          const KeyframeInertia& /*inertia*/) override {
    seen.push_back(scan.T_odom_body);
    if (asked++ != at) return std::nullopt;
    KeyframeMove move;
    for (SE3& T : seen) {
      T.p += shift_m;
      move.earlier.push_back(T);
    }
    move.T_odom_body = seen.back();
    move.earlier.pop_back();
    return move;
  }
};

// If the map were not moved, the next registration would pull the pose back to it.
TEST(PaperOdometry, continues_from_a_corrected_keyframe_and_map) {
  Bench b;
  b.end_s = 4.0;
  b.settings.paper.keyframe_s = 0.5;
  const auto odometry = odometry_of(b);
  MoveOnce corrector;
  odometry->correct_keyframes_by(&corrector);
  Rng rng(b.seed);
  SerialExecutor executor;
  FindingList findings;
  double imu_s = 0.0;
  for (double t_s = 0.1; t_s < b.end_s; t_s += 0.1) {
    for (; imu_s <= t_s + 0.0051; imu_s += 0.005) {
      odometry->add_imu(b.imu.sample(b.drive, imu_s, rng));
    }
    const ScanResult r =
        odometry->process(scan(b.room, b.drive, b.lidar, t_s, rng), executor, findings);
    if (corrector.asked <= corrector.at) continue;
    EXPECT_LT((r.T_odom_body.p - corrector.shift_m - b.drive.pose(t_s).p).norm(), 0.05) << t_s;
  }
  EXPECT_GT(corrector.asked, 2);
}

// Sixteen rings hit hardly any floor: without gravity the height drifted by metres in corridors.
TEST(PaperOdometry, keeps_height_and_level_with_sixteen_rings) {
  Bench b;
  b.lidar.rings = 16;
  b.lidar.columns = 1800;
  const Track track = run(b);
  EXPECT_EQ(track.good, track.scans);
  EXPECT_LT(track.worst_m, 0.05);
  EXPECT_LT(track.worst_deg, 0.5);
}

TEST(PaperOdometry, follows_a_drive_with_every_interpretation_of_the_paper) {
  for (const int variant : {0, 1, 2, 3}) {
    Bench b;
    b.end_s = 3.5;
    PaperSettings& s = b.settings.paper;
    s.literal = variant == 0;
    if (variant == 1) s.weight_place = WeightPlace::kOutside;
    if (variant == 2) s.kin_scale = KinematicScale::kQuartile;
    if (variant == 3) s.map_normal_max_deg = 180.0;
    const Track track = run(b);
    EXPECT_LT(track.worst_m, 0.15) << "variant " << variant;
    EXPECT_LT(track.worst_deg, 2.0) << "variant " << variant;
  }
}

TEST(PaperOdometry, works_with_lidar_and_imu_away_from_the_body_origin) {
  Bench b;
  b.end_s = 4.0;
  b.settings.paper.deskew = PaperDeskew::kFull;
  b.lidar.T_body_lidar = {geometry::rotation_from_rpy(0.0, 0.1, 0.5), Vec3(0.3, -0.1, 0.2)};
  b.imu.T_body_imu = {geometry::rotation_from_rpy(0.2, -0.1, 1.0), Vec3(-0.2, 0.1, -0.1)};
  const Track track = run(b);
  EXPECT_EQ(track.good, track.scans);
  EXPECT_LT(track.worst_m, 0.05);
  EXPECT_LT(track.worst_deg, 0.6);
  EXPECT_LT(track.worst_mps, 0.4);
}

TEST(PaperOdometry, works_without_imu_at_constant_velocity) {
  Bench b;
  b.has_imu = false;
  b.settings.paper.deskew = PaperDeskew::kFull;
  const Track track = run(b);
  // 16 rings hit no floor here (finding F2): the height depends on the motion model alone.
  EXPECT_LT(track.worst_m, 0.25);
  EXPECT_LT(track.worst_deg, 1.5);
  EXPECT_GE(track.scans, 49);
}

TEST(PaperOdometry, reports_missing_rings_once_and_works_without_them) {
  Bench b;
  b.end_s = 3.0;
  b.has_rings = false;
  const Track track = run(b);
  int reported = 0;
  for (const Finding& f : track.findings) reported += f.id == "odometry.no_rings" ? 1 : 0;
  EXPECT_EQ(reported, 1);
  EXPECT_LT(track.worst_m, 0.15);
}

TEST(PaperOdometry, pose_information_is_at_least_that_assumed_for_the_registration) {
  Bench b;
  b.end_s = 3.0;
  const Track track = run(b);
  const geometry::Mat6& P = track.last.covariance;
  EXPECT_EQ(P, P.transpose());
  EXPECT_GT(P.ldlt().vectorD().minCoeff(), 0.0);
  // With the graph the pose is more certain than from the assumed fraction of the registration.
  const geometry::Mat6 assumed =
      b.settings.paper.registration_fraction * track.last.lidar_information;
  EXPECT_GT((P.inverse() - assumed).eigenvalues().real().minCoeff(),
            -1e-6 * assumed.diagonal().maxCoeff());
}

TEST(PaperOdometry, gives_the_same_bytes_for_the_same_input) {
  Bench b;
  b.end_s = 2.5;
  EXPECT_EQ(run(b).hash, run(b).hash);
  Bench other = b;
  other.seed = 2;
  EXPECT_NE(run(b).hash, run(other).hash);
}

TEST(PaperOdometry, reports_a_start_in_motion) {
  Bench b;
  b.end_s = 2.0;
  b.drive.rest_s = -2.0;
  Track track;
  const auto odometry = odometry_of(b);
  SerialExecutor executor;
  Rng rng(1);
  for (double s = 0.0; s < 1.0; s += 0.005) odometry->add_imu(b.imu.sample(b.drive, s, rng));
  ScanResult r;
  for (double t_s = 0.1; t_s < 1.0; t_s += 0.1) {
    r = odometry->process(scan(b.room, b.drive, b.lidar, t_s, rng), executor, track.findings);
  }
  EXPECT_NE(r.state, TrackState::kWaiting);
  EXPECT_TRUE(has_finding(track.findings, "odometry.start_in_motion"));
}

// A corridor without ends: no point constrains the pose along it, so it must stay at the guess,
// which does not move.
TEST(PaperOdometry, keeps_the_prediction_along_a_degenerate_direction) {
  Bench b;
  b.room.low.x() = -1e4;
  b.room.high.x() = 1e4;
  b.room.low.y() = -1.2;
  b.room.high.y() = 1.2;
  b.drive.rest_s = 100.0;
  const Track track = run(b);
  EXPECT_LT(std::abs(track.last.T_odom_body.p.y()), 0.02);
  EXPECT_LT(std::abs(track.last.T_odom_body.p.z()), 0.05);
  EXPECT_LT(std::abs(track.last.T_odom_body.p.x()), 0.3);
}

class PaperOdometryRubbish : public ::testing::Test {
 protected:
  ScanResult process(const sensor::LidarScan& scan) {
    return odometry_->process(scan, executor_, findings_);
  }

  void start_at_rest(double end_s) {
    for (double s = 0.0; s < end_s; s += 0.005)
      odometry_->add_imu(b_.imu.sample(b_.drive, s, rng_));
    for (double t_s = 0.1; t_s < end_s - 0.01; t_s += 0.1) {
      last_ = process(scan(b_.room, b_.drive, b_.lidar, t_s, rng_));
    }
  }

  static sensor::LidarScan empty_scan(double end_s) {
    sensor::LidarScan scan;
    scan.t_start = Time::from_s(end_s - 0.1);
    scan.t_end = Time::from_s(end_s);
    scan.has_rings = true;
    scan.has_point_times = true;
    return scan;
  }

  static Bench standing() {
    Bench b;
    b.drive.rest_s = 100.0;
    return b;
  }

  Bench b_ = standing();
  Rng rng_{1};
  std::unique_ptr<Odometry> odometry_ = odometry_of(b_);
  SerialExecutor executor_;
  FindingList findings_;
  ScanResult last_;
};

TEST_F(PaperOdometryRubbish, waits_without_inertial_data) {
  EXPECT_EQ(process(empty_scan(0.1)).state, TrackState::kWaiting);
  EXPECT_EQ(process(scan(b_.room, b_.drive, b_.lidar, 0.2, rng_)).state, TrackState::kWaiting);
}

TEST_F(PaperOdometryRubbish, predicts_through_empty_scans_and_recovers) {
  start_at_rest(1.5);
  ASSERT_EQ(last_.state, TrackState::kGood);
  for (double s = 1.5; s < 2.4; s += 0.005) odometry_->add_imu(b_.imu.sample(b_.drive, s, rng_));
  for (double t_s = 1.6; t_s < 2.05; t_s += 0.1) {
    const ScanResult r = process(empty_scan(t_s));
    EXPECT_EQ(r.state, TrackState::kPredicted);
    EXPECT_TRUE(r.T_odom_body.p.allFinite());
    EXPECT_EQ(r.keyframe, nullptr);
    EXPECT_LT((r.T_odom_body.p - last_.T_odom_body.p).norm(), 0.02) << "it stands";
  }
  EXPECT_EQ(process(scan(b_.room, b_.drive, b_.lidar, 2.1, rng_)).state, TrackState::kGood);
}

TEST_F(PaperOdometryRubbish, stays_finite_with_nan_and_extreme_points) {
  start_at_rest(1.5);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  double t_s = 1.6;
  for (const float value : {nan, 0.0F, 1e30F, -1e-30F, std::numeric_limits<float>::infinity()}) {
    sensor::LidarScan scan = empty_scan(t_s);
    for (int k = 0; k < 500; ++k) {
      scan.push_back(value, k % 2 == 0 ? value : 1.0F, value, 0.0F, k % 3 == 0 ? nan : 0.01F,
                     static_cast<std::uint16_t>(k % 40));
    }
    const ScanResult r = process(scan);
    EXPECT_TRUE(r.T_odom_body.p.allFinite());
    EXPECT_TRUE(r.covariance.allFinite());
    t_s += 0.1;
  }
}

TEST_F(PaperOdometryRubbish, keeps_the_pose_when_scan_times_go_backwards) {
  start_at_rest(1.5);
  const SE3 before = last_.T_odom_body;
  const ScanResult r = process(scan(b_.room, b_.drive, b_.lidar, 1.0, rng_));
  EXPECT_EQ(r.state, TrackState::kPredicted);
  EXPECT_LT((r.T_odom_body.p - before.p).norm(), 1e-9);
}

TEST_F(PaperOdometryRubbish, ignores_nan_and_late_imu_samples) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  odometry_->add_imu({Time::from_s(0.001), Vec3(nan, 0, 0), Vec3::Zero()});
  odometry_->add_imu({Time::from_s(0.001), Vec3::Zero(), Vec3::Constant(nan)});
  start_at_rest(1.5);
  odometry_->add_imu({Time::from_s(0.5), Vec3::Constant(100.0), Vec3::Constant(1e6)});  // late
  EXPECT_EQ(last_.state, TrackState::kGood);
  const ScanResult r = process(scan(b_.room, b_.drive, b_.lidar, 1.5, rng_));
  EXPECT_LT(r.T_odom_body.p.norm(), 0.05);
}

// Moved without any data: the new place has nothing in common with the map.
TEST_F(PaperOdometryRubbish, recovers_when_scans_no_longer_match_the_map) {
  b_.settings.paper.matches_min = 100;
  odometry_ = odometry_of(b_);
  start_at_rest(1.5);
  ASSERT_EQ(last_.state, TrackState::kGood);
  for (double s = 1.5; s < 5.0; s += 0.005) odometry_->add_imu(b_.imu.sample(b_.drive, s, rng_));
  b_.room = {Vec3(-6.5, -5.5, -1.4), Vec3(7.5, 6.0, 2.7)};
  for (double t_s = 1.6; t_s < 4.9; t_s += 0.1) {
    last_ = process(scan(b_.room, b_.drive, b_.lidar, t_s, rng_));
    EXPECT_TRUE(last_.T_odom_body.p.allFinite());
  }
  EXPECT_EQ(last_.state, TrackState::kGood);
}

}  // namespace
}  // namespace rali::odometry
