#include "rali/vehicle/back_end.hpp"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::vehicle {
namespace {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

const Vec3 kGravity(0.0, 0.0, -9.81);
constexpr double kSpeed_mps = 1.0;
constexpr double kDrive_s = 40.0;
constexpr double kGapFrom_s = 15.0, kGapTo_s = 25.0;

/// A straight drive along x in a tunnel: the LiDAR sees all but x. Another vehicle stands 10 m
/// behind the start and 1 m aside. In the gap of the radio the filter drifts 1 m, and comes back
/// with the first range.
struct Drive {
  bool blind = true, ranges = true, imu = true;
  double gap_from_s = kGapFrom_s, gap_to_s = kGapTo_s;

  [[nodiscard]] double drift_m(double t_s) const {
    if (t_s < gap_from_s || t_s >= gap_to_s) return 0.0;
    return (t_s - gap_from_s) / (gap_to_s - gap_from_s);
  }

  [[nodiscard]] static Vec3 truth(double t_s) { return {kSpeed_mps * t_s, 0.0, 0.0}; }

  [[nodiscard]] odometry::ScanResult scan(double t_s) const {
    odometry::ScanResult r;
    r.t = Time::from_s(t_s);
    r.state = odometry::TrackState::kGood;
    r.inertial = imu;
    r.T_odom_body.p = truth(t_s) + Vec3(drift_m(t_s), 0.0, 0.0);
    r.v_odom_mps = {kSpeed_mps, 0.0, 0.0};
    r.covariance = 1e-6 * Mat6::Identity();
    r.lidar_information = 1e6 * Mat6::Identity();
    if (blind) r.lidar_information(3, 3) = 0.0;
    return r;
  }

  /// What finish() tells, by time.
  [[nodiscard]] std::map<std::int64_t, KeyframeCorrected> run() const {
    BackEnd back_end(VehicleId{1}, VehicleSettings{});
    PathRecorder path{VehicleSettings{}};
    Rng rng(5, "back end");
    const Vec3 anchor(-10.0, 1.0, 0.0);
    std::uint64_t id = 0;
    std::uint32_t seq = 0;
    for (int k = 0; k <= static_cast<int>(kDrive_s * 10); ++k) {
      const double t_s = 0.1 * k;
      std::vector<RangeRecord> heard;
      for (int i = 0; i < 20 && imu; ++i) {
        sensor::ImuSample sample;
        sample.t = Time::from_s(t_s - 0.1 + 0.005 * (i + 1));
        sample.accel_mps2 = -kGravity;
        path.add(sample);
      }
      const bool silent = t_s > gap_from_s && t_s < gap_to_s;
      if (ranges && !silent) {
        RangeRecord r;
        r.id = id++;
        r.t = Time::from_s(t_s);
        r.T_odom_body = scan(t_s).T_odom_body;
        r.range_m = (truth(t_s) - anchor).norm() + 0.03 * rng.normal();
        r.sigma_m = 0.05;
        r.R_m2 = 0.05 * 0.05;
        r.rate_mps = kSpeed_mps;
        r.used = true;
        heard.push_back(r);
      }
      std::optional<KeyframeId> keyframe;
      if (k % 5 == 0) keyframe = KeyframeId{VehicleId{1}, seq++};
      back_end.add(path.add(scan(t_s), keyframe, blind, kGravity), heard);
    }
    OutputList out;
    const std::vector<PlaceRecord> places = {{0, anchor, 0.01 * Mat3::Identity()}};
    const std::vector<PairRecord> pairs = {{0, 0.0, 0.05}};
    back_end.finish(places, pairs, kGravity, out);
    std::map<std::int64_t, KeyframeCorrected> told;
    for (const Output& o : out) {
      const auto& corrected = std::get<KeyframeCorrected>(o);
      told[corrected.t.ns] = corrected;
    }
    return told;
  }
};

TEST(BackEnd, takes_back_what_the_filter_drifted_while_the_radio_was_silent) {
  const auto told = Drive{}.run();
  ASSERT_EQ(told.size(), 81U);
  for (const auto& [ns, corrected] : told) {
    const double t_s = corrected.t.s();
    EXPECT_NEAR(corrected.T_local_body.p.x(), Drive::truth(t_s).x(), 0.15) << t_s;
    EXPECT_NEAR(corrected.T_local_body.p.y(), 0.0, 0.02) << t_s;
    EXPECT_GT(corrected.covariance(3, 3), 0.0) << t_s;
  }
}

TEST(BackEnd, knows_less_in_the_gap_than_where_ranges_are_heard) {
  const auto told = Drive{}.run();
  const double before = told.at(Time::from_s(10.0).ns).covariance(3, 3);
  const double within = told.at(Time::from_s(20.0).ns).covariance(3, 3);
  EXPECT_GT(within, before);
}

TEST(BackEnd, says_nothing_of_a_stretch_that_was_never_blind) {
  Drive drive;
  drive.blind = false;
  EXPECT_TRUE(drive.run().empty());
}

TEST(BackEnd, says_nothing_without_ranges_or_without_inertial_data) {
  Drive deaf;
  deaf.ranges = false;
  EXPECT_TRUE(deaf.run().empty());
  Drive numb;
  numb.imu = false;
  EXPECT_TRUE(numb.run().empty());
}

TEST(BackEnd, same_drive_gives_the_same_bits) {
  const auto a = Drive{}.run();
  const auto b = Drive{}.run();
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [ns, corrected] : a) {
    EXPECT_EQ(corrected.T_local_body.p, b.at(ns).T_local_body.p);
    EXPECT_EQ(corrected.covariance, b.at(ns).covariance);
  }
}

}  // namespace
}  // namespace rali::vehicle
