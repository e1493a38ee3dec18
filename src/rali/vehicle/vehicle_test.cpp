#include "rali/vehicle/vehicle.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "rali/odometry/room_for_test.hpp"

namespace rali::vehicle {
namespace {

using odometry::TestRoom;
using sensor::ImuSample;
using sensor::LidarScan;

TestRoom small_room() {
  TestRoom room;
  room.rings = 8;
  room.columns = 200;
  return room;
}

VehicleSettings settings_of(const TestRoom& room, bool has_imu) {
  VehicleSettings settings;
  settings.name = "scout";
  settings.calibration.T_body_lidar = room.T_body_lidar;
  settings.has_imu = has_imu;
  return settings;
}

template <class T>
std::vector<T> all_of(const OutputList& out) {
  std::vector<T> found;
  for (const Output& o : out) {
    if (const T* v = std::get_if<T>(&o)) found.push_back(*v);
  }
  return found;
}

bool finite(const PoseEstimate& p) {
  return p.T_odom_body.p.allFinite() && p.T_odom_body.R.allFinite() && p.v_odom_mps.allFinite() &&
         p.covariance.allFinite() && std::isfinite(p.residual_rms_m);
}

std::shared_ptr<const LidarScan> freeze(std::shared_ptr<LidarScan> scan) { return scan; }

/// A vehicle with its own executor and list, fed event by event.
struct Driver {
  Vehicle vehicle;
  SerialExecutor executor;
  OutputList out;

  Driver(std::uint16_t id, const VehicleSettings& settings) : vehicle(VehicleId{id}, settings) {}

  std::size_t poses() const { return all_of<PoseEstimate>(out).size(); }

  void feed(const Event& event) { vehicle.step(event, executor, out); }

  void feed_imu(TestRoom& room, double from_s, double to_s) {
    for (double t_s = from_s; t_s < to_s - 1e-9; t_s += 0.005) feed(room.imu(t_s));
  }
};

TEST(Vehicle, outputs_a_pose_per_scan_and_a_keyframe_for_the_first) {
  TestRoom room = small_room();
  Driver d(3, settings_of(room, false));
  for (int k = 0; k < 4; ++k) d.feed(freeze(room.scan(0.1 * k)));
  const auto poses = all_of<PoseEstimate>(d.out);
  ASSERT_EQ(poses.size(), 4U);
  EXPECT_EQ(poses[1].vehicle.value, 3);
  EXPECT_EQ(poses[1].t, room.scan(0.1)->t_end);
  const auto keyframes = all_of<KeyframeAdded>(d.out);
  ASSERT_EQ(keyframes.size(), 1U);
  EXPECT_EQ(keyframes[0].id.seq, 0U);
  EXPECT_EQ(keyframes[0].id.vehicle.value, 3);
  EXPECT_GT(keyframes[0].keyframe->cloud.size(), 500U);
}

TEST(Vehicle, in_a_later_epoch_offsets_keyframe_numbers_and_restarts_fact_numbers) {
  TestRoom room = small_room();
  VehicleSettings settings = settings_of(room, false);
  settings.facts.epoch = 3;
  Driver d(1, settings);
  for (int k = 0; k < 2; ++k) d.feed(freeze(room.scan(0.1 * k)));
  const auto keyframes = all_of<KeyframeAdded>(d.out);
  ASSERT_EQ(keyframes.size(), 1U);
  EXPECT_EQ(keyframes[0].id.seq, 3U << 20);
  const auto facts = all_of<FactMade>(d.out);
  ASSERT_GE(facts.size(), 3U);
  for (std::uint32_t seq = 0; seq < facts.size(); ++seq) {
    EXPECT_EQ(facts[seq].fact->key, (fleet::FactKey{VehicleId{1}, 3, seq}));
  }
  const auto& points = std::get<fleet::KeyframePoints>(facts[2].fact->body);
  EXPECT_EQ(points.keyframe, 3U << 20);
}

TEST(Vehicle, refuses_late_repeated_and_null_scans_with_a_finding) {
  TestRoom room = small_room();
  Driver d(0, settings_of(room, false));
  d.feed(freeze(room.scan(1.0)));
  ASSERT_EQ(d.poses(), 1U);
  const std::uint64_t before = d.vehicle.state_hash();
  d.feed(freeze(room.scan(0.5)));
  d.feed(freeze(room.scan(1.0)));  // the same once more
  d.feed(std::shared_ptr<const LidarScan>());
  EXPECT_EQ(d.poses(), 1U);
  EXPECT_EQ(d.vehicle.state_hash(), before);
  const auto findings = all_of<Finding>(d.out);
  ASSERT_EQ(findings.size(), 3U);
  for (const Finding& f : findings) {
    EXPECT_EQ(f.id, "vehicle.late_scan");
    EXPECT_EQ(f.vehicle, "scout");
    EXPECT_FALSE(f.text.empty());
  }
}

TEST(Vehicle, holds_a_scan_back_until_inertial_data_reach_its_end) {
  TestRoom room = small_room();
  Driver d(0, settings_of(room, true));
  d.feed_imu(room, 0.0, 0.05);
  const auto scan = freeze(room.scan(0.0));
  d.feed(scan);
  EXPECT_EQ(d.poses(), 0U);
  ImuSample last = room.imu(0.09);
  last.t = scan->t_end - Duration{1};
  d.feed(last);
  EXPECT_EQ(d.poses(), 0U);
  last.t = scan->t_end;
  d.feed(last);
  EXPECT_EQ(d.poses(), 1U);
}

TEST(Vehicle, processes_scans_after_0_2_s_without_inertial_data) {
  TestRoom room = small_room();
  Driver d(0, settings_of(room, true));
  for (int k = 0; k < 5; ++k) d.feed(freeze(room.scan(0.1 * k)));
  // Scans wait for 0.2 s: the last two are still waiting.
  EXPECT_EQ(d.poses(), 3U);
  d.feed(EndOfData{});
  EXPECT_EQ(d.poses(), 5U);
  EXPECT_EQ(all_of<GravityEstimate>(d.out).size(), 1U);
}

TEST(Vehicle, handles_end_of_data_without_any_data) {
  Driver d(0, VehicleSettings{});
  d.feed(EndOfData{});
  EXPECT_EQ(d.poses(), 0U);
  for (const GravityEstimate& g : all_of<GravityEstimate>(d.out)) {
    EXPECT_TRUE(g.g_odom_mps2.allFinite());
  }
}

TEST(Vehicle, survives_empty_and_tiny_scans_with_finite_poses) {
  TestRoom room = small_room();
  Driver d(0, settings_of(room, false));
  const auto broken = [](double t_s, int points) {
    auto scan = std::make_shared<LidarScan>();
    scan->t_start = Time::from_s(t_s);
    scan->t_end = Time::from_s(t_s + 0.099);
    for (int k = 0; k < points; ++k) {
      scan->push_back(1.0F + 0.1F * static_cast<float>(k), 2.0F, 0.0F, 0.0F, 0.0F, 0);
    }
    return freeze(scan);
  };
  d.feed(broken(0.0, 0));  // nothing before the first points: no pose
  EXPECT_EQ(d.poses(), 0U);
  d.feed(broken(0.1, 1));
  d.feed(broken(0.2, 0));
  d.feed(broken(0.3, 3));
  for (int k = 4; k < 10; ++k) d.feed(freeze(room.scan(0.1 * k)));
  d.feed(broken(1.0, 0));
  d.feed(broken(1.1, 5));
  const auto poses = all_of<PoseEstimate>(d.out);
  EXPECT_EQ(poses.size(), 11U);
  for (const PoseEstimate& p : poses) EXPECT_TRUE(finite(p));
  EXPECT_EQ(poses.back().quality, PoseQuality::kPredicted);
  EXPECT_TRUE(poses.back().degeneracy.degenerate);
}

/// State after scans with ranges of 3 m to a vehicle of unknown position.
std::uint64_t after_hearing(TestRoom room, double shell_m, int scans = 30, double hold_s = 10.0) {
  VehicleSettings settings = settings_of(room, true);
  settings.peer_mask.shell_m = shell_m;
  settings.peer_mask.shell_hold_s = hold_s;
  PeerSettings peer;
  peer.id = VehicleId{1};
  peer.antennas_body_m = {geometry::Vec3::Zero()};
  settings.antennas_body_m = {geometry::Vec3::Zero()};
  settings.peers.push_back(peer);
  Driver d(0, settings);
  for (int k = 0; k < scans; ++k) {
    sensor::RangeSample range;
    range.t = Time::from_s(0.1 * k + 0.05);
    range.from = VehicleId{0};
    range.to = VehicleId{1};
    range.range_m = 3.0;
    d.feed(range);
    d.feed(freeze(room.scan(0.1 * k)));
    d.feed_imu(room, 0.1 * k, 0.1 * (k + 1));
  }
  return d.vehicle.state_hash();
}

// In a tunnel, a column takes itself for static objects; in a room walls at that range are worth
// more.
TEST(Vehicle, masks_points_at_the_range_of_a_peer_only_under_degeneracy) {
  const TestRoom room;
  EXPECT_EQ(after_hearing(room, 1.0), after_hearing(room, 0.0));
  TestRoom tunnel = small_room();
  tunnel.walls = {{-500.0, -2.5, -1.0}, {500.0, 2.5, 2.6}};
  tunnel.pillars.clear();
  tunnel.radius_m = 1e4;
  EXPECT_NE(after_hearing(tunnel, 1.0), after_hearing(tunnel, 0.0));
  EXPECT_EQ(after_hearing(tunnel, 1.0, 6), after_hearing(tunnel, 0.0, 6)) << "blind for 0.4 s";
  EXPECT_EQ(after_hearing(tunnel, 1.0, 30, 0.0), after_hearing(tunnel, 0.0)) << "not held";
}

// The other vehicles compute their lateral offset from these.
TEST(Vehicle, reports_wall_distances_at_standstill_only_in_a_passage) {
  const auto walls = [](TestRoom room) {
    VehicleSettings settings = settings_of(room, true);
    settings.antennas_body_m = {geometry::Vec3(0.0, 0.25, 0.0)};
    settings.peers.emplace_back().id = VehicleId{1};
    Driver d(0, settings);
    for (int k = 0; k < 50; ++k) {
      d.feed(freeze(room.scan(0.1 * k)));
      d.feed_imu(room, 0.1 * k, 0.1 * (k + 1));
    }
    const std::vector<PeerStatus> reported = all_of<PeerStatus>(d.out);
    EXPECT_TRUE(reported.back().at_rest);
    EXPECT_TRUE(reported.back().pose);
    return reported.back().pose ? reported.back().pose->walls : std::nullopt;
  };
  TestRoom tunnel;
  tunnel.walls = {{-500.0, -1.5, -1.0}, {500.0, 3.0, 2.6}};
  tunnel.pillars.clear();
  tunnel.radius_m = 1e4;
  tunnel.stop_s = 3.0;
  const auto beside = walls(tunnel);
  ASSERT_TRUE(beside);
  const bool along = beside->axis.x() > 0.0;
  EXPECT_NEAR(std::abs(beside->axis.x()), 1.0, 0.01);
  EXPECT_NEAR(along ? beside->left_m : beside->right_m, 2.75, 0.05);
  EXPECT_NEAR(along ? beside->right_m : beside->left_m, 1.75, 0.05);
  TestRoom room;
  room.rest_s = 10.0;
  EXPECT_FALSE(walls(room)) << "it is no passage";
}

TEST(Vehicle, one_broken_inertial_sample_does_not_spoil_the_poses) {
  TestRoom room = small_room();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf}) {
    Driver d(0, settings_of(room, true));
    for (int k = 0; k < 20; ++k) {
      d.feed(freeze(room.scan(0.1 * k)));
      d.feed_imu(room, 0.1 * k, 0.1 * (k + 1));
      if (k == 15) {
        ImuSample sample = room.imu(1.6);
        sample.t = Time::from_s(1.5975);
        sample.gyro_radps.x() = bad;
        d.feed(sample);
      }
    }
    const auto poses = all_of<PoseEstimate>(d.out);
    EXPECT_GE(poses.size(), 19U);
    for (const PoseEstimate& p : poses) EXPECT_TRUE(finite(p)) << bad;
    EXPECT_LT((poses.back().T_odom_body.p - room.pose(2.0).p).norm(), 0.1) << bad;
    bool reported = false;
    for (const Finding& f : all_of<Finding>(d.out))
      reported = reported || f.id == "vehicle.broken_imu";
    EXPECT_TRUE(reported) << "a sample that was refused must be told";
  }
}

/// Events of a short drive.
std::vector<Event> recording(std::uint64_t seed) {
  TestRoom room = small_room();
  room.rng = Rng(seed, "room");
  room.rest_s = 0.2;
  std::vector<Event> events;
  for (int k = 0; k < 8; ++k) {
    events.emplace_back(freeze(room.scan(0.1 * k)));
    for (int i = 0; i < 20; ++i) events.emplace_back(room.imu(0.1 * k + 0.005 * i));
  }
  events.emplace_back(EndOfData{});
  return events;
}

TEST(Vehicle, state_hash_depends_only_on_the_events) {
  const VehicleSettings settings = settings_of(small_room(), true);
  const auto hash_after = [&](std::uint64_t seed) {
    Driver d(0, settings);
    for (const Event& e : recording(seed)) d.feed(e);
    return d.vehicle.state_hash();
  };
  EXPECT_EQ(hash_after(1), hash_after(1));
  EXPECT_NE(hash_after(1), hash_after(2));
}

TEST(Vehicle, two_in_one_process_do_not_disturb_each_other) {
  const VehicleSettings settings = settings_of(small_room(), true);
  const std::vector<Event> first = recording(1);
  const std::vector<Event> second = recording(2);
  Driver alone(0, settings);
  for (const Event& e : first) alone.feed(e);
  Driver a(0, settings);
  Driver b(1, settings);
  for (std::size_t k = 0; k < first.size(); ++k) {  // turn by turn
    a.feed(first[k]);
    b.feed(second[k]);
  }
  EXPECT_EQ(a.vehicle.state_hash(), alone.vehicle.state_hash());
  EXPECT_NE(b.vehicle.state_hash(), a.vehicle.state_hash());
  ASSERT_EQ(a.out.size(), alone.out.size());
  const auto pa = all_of<PoseEstimate>(a.out);
  const auto pb = all_of<PoseEstimate>(alone.out);
  for (std::size_t k = 0; k < pa.size(); ++k) {
    EXPECT_EQ(pa[k].T_odom_body.p, pb[k].T_odom_body.p);
    EXPECT_EQ(pa[k].covariance, pb[k].covariance);
  }
}

TEST(Vehicle, can_be_move_constructed) {
  TestRoom room = small_room();
  Vehicle a(VehicleId{0}, settings_of(room, false));
  SerialExecutor executor;
  OutputList out;
  a.step(freeze(room.scan(0.0)), executor, out);
  Vehicle b = std::move(a);
  b.step(freeze(room.scan(0.1)), executor, out);
  EXPECT_EQ(all_of<PoseEstimate>(out).size(), 2U);
}

}  // namespace
}  // namespace rali::vehicle
