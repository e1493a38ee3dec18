#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/odometry/augmented_filter_for_test.hpp"
#include "rali/vehicle/range_stage.hpp"

namespace rali::vehicle {
namespace {

using geometry::Vec3;
using odometry::DenseAugmentedFilter;
using sensor::RangeSample;

constexpr VehicleId kSelf{1};
constexpr VehicleId kPeer{2};

/// A peer 40 m ahead in a passage, 1.2 m to the left of the path, with a prior 4 m to the right.
/// Its ranges are 0.05 m too long, with 0.1 m of noise and 0.1 m of error that changes over
/// seconds.
struct Passing {
  DenseAugmentedFilter filter;
  RangeStage stage;
  OutputList out;
  Rng rng{7, "ranges"};
  double wander_m = 0.0;
  double x_m = 0.0;
  double worst_pose_m = 0.0;
  double worst_bias_m = 0.0;
  int ranges = 0;

  static constexpr double kStep_s = 0.05;

  static VehicleSettings settings() {
    VehicleSettings out;
    PeerSettings peer;
    peer.id = kPeer;
    peer.antennas_body_m = {Vec3::Zero()};
    peer.prior.emplace();
    peer.prior->T_self_peer.p = Vec3(40.0, -4.0, 0.0);
    peer.prior->sigma_rad = 0.08;
    out.peers.push_back(peer);
    return out;
  }

  Passing() : stage(kSelf, settings()) {
    filter.axis = Vec3::UnitX();
    filter.P.diagonal().segment<3>(3) << 1e-4, 1e-4, 1e-4;
    filter.P.diagonal().segment<3>(6) << 1e-4, 1e-8, 1e-8;
  }

  /// Drives on at that speed; at standstill the odometry has a zero-velocity update.
  void drive(double speed_mps, double duration_s) {
    const auto steps = static_cast<int>(duration_s / kStep_s);
    for (int k = 0; k < steps; ++k) step(speed_mps);
  }

  /// Drives without ranges, with odometry that is a little too fast.
  void drive_unheard(double speed_mps, double duration_s, double wrong_mps) {
    silent_ = true;
    filter.now.v_odom_mps.x() += wrong_mps;
    drive(speed_mps, duration_s);
    silent_ = false;
  }

  void step(double speed_mps) {
    const double t_s = kStep_s * ++ranges;
    filter.now.v_odom_mps.x() += speed_mps - speed_mps_;
    speed_mps_ = speed_mps;
    x_m += speed_mps * kStep_s;
    if (speed_mps == 0.0) {
      stand();
    } else {
      filter.P(3, 3) += 2.0 * kStep_s * filter.P(3, 6) + kStep_s * kStep_s * filter.P(6, 6);
      filter.P.block(3, 6, 1, 1) += kStep_s * filter.P.block(6, 6, 1, 1);
      filter.P(6, 3) = filter.P(3, 6);
      filter.P(6, 6) += 5e-6;
    }
    static_cast<void>(filter.advance_to(Time::from_s(t_s)));
    stage.on(PeerStatus{kPeer, Time::from_s(t_s), true});
    wander_m += -wander_m * kStep_s / 2.0 + 0.1 * std::sqrt(2.0 * kStep_s / 2.0) * rng.normal();
    RangeSample s;
    s.t = Time::from_s(t_s);
    s.from = kSelf;
    s.to = kPeer;
    s.range_m = std::hypot(40.0 - x_m, 1.2) + 0.05 + wander_m + 0.1 * rng.normal();
    if (!silent_) stage.add(s, out);
    static_cast<void>(
        stage.run(Time::from_s(t_s), &filter, Vec3(0.0, 0.0, -9.81), geometry::SE3{}, out));
    worst_pose_m = std::max(worst_pose_m, std::abs(filter.now.T_odom_body.p.x() - x_m));
    if (filter.augmented().size() == 5) {
      worst_bias_m = std::max(worst_bias_m, std::abs(filter.augmented().mean[4] - 0.05));
    }
  }

 private:
  /// Zero-velocity update.
  void stand() {
    odometry::AugmentedMeasurement zero;
    zero.d_velocity = Eigen::RowVector3d::UnitX();
    zero.residual = -filter.now.v_odom_mps.x();
    static_cast<void>(filter.apply(zero, 1e-6));
  }

  double speed_mps_ = 0.0;
  bool silent_ = false;
};

/// A section of the path.
struct Leg {
  double speed_mps;
  double duration_s;
};

struct Path {
  const char* name;
  std::vector<Leg> legs;
};

TEST(RangePassage, stopping_or_turning_near_the_peer_keeps_position_and_bias_accurate) {
  const Path paths[] = {
      {"goes on", {{1.0, 70.0}}},
      {"halts 5 m before", {{1.0, 35.0}, {0.0, 90.0}}},
      {"halts beside", {{1.0, 40.0}, {0.0, 90.0}}},
      {"halts 3 m past", {{1.0, 43.0}, {0.0, 90.0}}},
      {"halts and goes on", {{1.0, 43.0}, {0.0, 90.0}, {1.0, 20.0}}},
      {"turns 5 m before", {{1.0, 35.0}, {-1.0, 35.0}}},
      {"turns 3 m past", {{1.0, 43.0}, {-1.0, 43.0}}},
      {"to and fro", {{1.0, 43.0}, {-1.0, 6.0}, {1.0, 6.0}, {-1.0, 6.0}, {1.0, 6.0}}}};
  for (const Path& path : paths) {
    Passing p;
    for (const Leg& leg : path.legs) p.drive(leg.speed_mps, leg.duration_s);
    ASSERT_EQ(p.filter.augmented().size(), 5) << path.name;
    // Its sigma is 0.1 m before any measurement.
    EXPECT_LT(p.worst_bias_m, 0.15) << path.name;
    EXPECT_LT(p.worst_pose_m, 0.45) << path.name;
    const double off_m = p.filter.now.T_odom_body.p.x() - p.x_m;
    EXPECT_LT(std::abs(off_m), 3.0 * std::sqrt(p.filter.P(3, 3))) << path.name;
  }
}

TEST(RangePassage, ranges_correct_the_pose_at_once_after_passing_without_them) {
  Passing p;
  p.drive(1.0, 20.0);
  p.drive_unheard(1.0, 45.0, 0.05);
  EXPECT_GT(p.filter.now.T_odom_body.p.x() - p.x_m, 2.0);
  p.drive(1.0, 2.0);
  EXPECT_LT(std::abs(p.filter.now.T_odom_body.p.x() - p.x_m), 0.45);
  // The nearest range was 20 m: the peer is behind now, which still ends the passage.
  p.worst_pose_m = 0.0;
  p.worst_bias_m = 0.0;
  p.drive(1.0, 120.0);
  EXPECT_LT(p.worst_pose_m, 0.45);
  EXPECT_LT(p.worst_bias_m, 0.15);
}

}  // namespace
}  // namespace rali::vehicle
