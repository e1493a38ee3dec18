#include "rali/drive/output/session_fleet.hpp"

#include <map>

#include <gtest/gtest.h>

#include "rali/drive/output/fleet_run_for_test.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/io/message_source.hpp"
#include "rali/wire/decode.hpp"

namespace rali::drive {
namespace {

using geometry::SE3;

constexpr VehicleId kV1{0}, kV2{1};

Time at(double t_s) { return Time::from_s(t_s); }

/// v2's odometry started 10 m along the corridor, rotated; its second keyframe drifted.
SE3 frame_of_v2() { return {geometry::rotation_from_rpy(0.0, 0.0, 0.5), {10.0, 1.0, 0.0}}; }

struct Written {
  io::TestFolder folder;
  std::vector<VehicleRun> runs;
  std::map<std::string, std::vector<std::vector<std::byte>>> messages;  ///< by topic
};

ranging::RangeUse range_at(double t_s, ranging::RangeReason reason) {
  ranging::RangeUse use;
  use.sample.t = at(t_s);
  use.sample.from = kV1;
  use.sample.to = kV2;
  use.sample.range_m = 5.0;
  use.reason = reason;
  return use;
}

void write_session(Written& out) {
  auto session = SessionFile::create(out.folder.path());
  ASSERT_TRUE(session);
  DrivenVehicle first(out.folder.path(), 0, session->get());
  out.runs.push_back(first.begin(2.0, true).stand(10.0).drive(8.0, 6.0).finish());
  DrivenVehicle second(out.folder.path(), 1, session->get());
  second.begin(3.0, false).drive(12.0, 8.0).drive(20.0, 8.0);
  vehicle::KeyframeCorrected moved;
  moved.id = {kV2, 2};
  moved.t = at(16.0);
  moved.T_local_body = map::test::pose_at(20.5, 1.5, 0.8);
  out.runs.push_back(second.finish(frame_of_v2(), {{2, moved}}));

  const FleetRunView fleet{&out.runs, {&out.runs[0], &out.runs[1]}, out.folder.path()};
  RangeLog ranges({"v1", "v2"});
  for (double t_s = 0.0; t_s < 16.0; t_s += 0.05) {
    ranges.add_refused(range_at(t_s, ranging::RangeReason::kNlos).sample,
                       ranging::RangeReason::kNlos);
  }
  fleet::FleetEstimate estimate;
  estimate.loops.resize(1);
  estimate.loops[0].from = {kV1, 0};
  estimate.loops[0].to = {kV2, 1};
  estimate.loops[0].accepted = true;
  FleetRounds rounds;
  rounds.rounds.resize(1);
  rounds.rounds[0].round = 1;
  rounds.rounds[0].end = at(10.0);
  rounds.frontiers.resize(1);
  rounds.frontiers[0].round = 1;
  MapJob job;
  job.vehicles.resize(2);
  ASSERT_TRUE(show_fleet(fleet, job, estimate, ranges, rounds, **session));
  ASSERT_TRUE((*session)->finish());

  auto source = io::open_recording(out.folder.path("session.mcap"));
  ASSERT_TRUE(source) << source.error().message();
  io::RawMessage message;
  for (auto more = (*source)->next(message); more && *more; more = (*source)->next(message)) {
    out.messages[(*source)->topics().at(message.topic).name].emplace_back(message.data.begin(),
                                                                          message.data.end());
  }
}

TEST(Session, transforms_give_the_final_pose_of_every_vehicle_at_every_scan) {
  Written out;
  write_session(out);
  std::map<std::pair<std::string, Time>, SE3> tf;
  for (const auto& bytes : out.messages["/tf"]) {
    const auto decoded = wire::decode_tf(bytes, wire::Encoding::kCdr);
    ASSERT_TRUE(decoded);
    for (const wire::TransformStamped& t : decoded->transforms) {
      EXPECT_EQ(t.frame_id, t.child_frame_id.ends_with("/odom") ? "map" : t.frame_id);
      tf[{t.child_frame_id, t.stamp}] = t.T_frame_child;
    }
  }
  for (const VehicleRun& run : out.runs) {
    for (const PoseRecord& pose : run.poses()) {
      ASSERT_TRUE(tf.contains({run.name() + "/odom", pose.t}));
      ASSERT_TRUE(tf.contains({run.name() + "/base_link", pose.t}));
      const SE3 chained =
          tf[{run.name() + "/odom", pose.t}] * tf[{run.name() + "/base_link", pose.t}];
      const SE3 final_pose = run.T_map_local() * pose.T_local_body;
      EXPECT_NEAR((chained.p - final_pose.p).norm(), 0.0, 1e-9);
      EXPECT_TRUE(chained.R.isApprox(final_pose.R, 1e-9));
    }
  }
  // In its published odometry, v2 ended at 20 m: the drift is in the frame above it.
  const SE3 last = tf[{"v2/base_link", at(16.0)}];
  EXPECT_NEAR(last.p.x(), 20.0, 1e-9);
  EXPECT_NEAR((tf[{"v2/odom", at(16.0)}].p - frame_of_v2().p).norm(), 0.5, 1e-9);
}

TEST(Session, contains_a_growing_map_ranges_loops_and_frontiers) {
  Written out;
  write_session(out);
  ASSERT_EQ(out.messages["/map"].size(), 16U);
  std::uint32_t before = 0;
  for (const auto& bytes : out.messages["/map"]) {
    const auto cloud = wire::decode_point_cloud2(bytes, wire::Encoding::kCdr);
    ASSERT_TRUE(cloud);
    EXPECT_EQ(cloud->frame_id, "map");
    EXPECT_GE(cloud->width, before);
    before = cloud->width;
  }
  EXPECT_GT(before, 1000U);
  EXPECT_EQ(out.messages["/ranges"].size(), 14U) << "16 s in pieces of 1.2 s: 1 s and one step";
  EXPECT_FALSE(out.messages["/loops"].empty());
  EXPECT_EQ(out.messages["/frontiers"].size(), 1U);
}

}  // namespace
}  // namespace rali::drive
