#include "rali/cli/demo/demo_recording.hpp"

#include <gtest/gtest.h>

#include "rali/config/load_fleet.hpp"
#include "rali/drive/open_events.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

sim::SimOptions short_drive() {
  sim::SimOptions options;
  options.scene = sim::Scene::kCorridor;
  options.duration_s = 1.0;
  options.imu_apart = true;
  return options;
}

TEST(DemoRecording, is_read_as_it_was_simulated) {
  const io::TestFolder folder;
  const auto made = write_demo_recording(short_drive(), folder.path(), [](double) { return true; });
  ASSERT_TRUE(made) << made.error().message();
  const auto fleet = config::load_fleet(made->fleet_file, {});
  ASSERT_TRUE(fleet) << fleet.error().message();
  const geometry::SE3& T_body_imu = fleet->vehicles.at(0).imu.T_body_imu.T;
  EXPECT_NEAR(T_body_imu.p.z(), 0.08, 1e-9);
  EXPECT_NEAR(T_body_imu.R(1, 0), 1.0, 1e-5) << "x of the IMU is y of the body";
  drive::VehicleJob job;
  job.inputs = {folder.path("v1.mcap")};
  const auto source = drive::open_events(job);
  ASSERT_TRUE(source) << source.error().message();
  std::size_t sweeps = 0, samples = 0;
  for (;;) {
    const auto event = (*source)->next();
    ASSERT_TRUE(event);
    if (!event->has_value()) break;
    if (const auto* scan = std::get_if<std::shared_ptr<const sensor::LidarScan>>(&**event)) {
      EXPECT_TRUE((*scan)->has_point_times && (*scan)->has_rings);
      ASSERT_LT(sweeps, made->truth.size());
      EXPECT_NEAR(seconds_between(made->truth[sweeps].t, (*scan)->t_end), 0.0, 1e-4);
      ++sweeps;
    }
    samples += std::holds_alternative<sensor::ImuSample>(**event) ? 1 : 0;
  }
  EXPECT_EQ(sweeps, made->truth.size());
  EXPECT_GE(sweeps, 8U);
  EXPECT_GE(samples, 190U);
}

TEST(DemoRecording, has_the_same_bytes_each_time) {
  const io::TestFolder folder;
  sim::SimOptions options = short_drive();
  options.duration_s = 0.3;
  for (const char* name : {"a", "b"}) {
    ASSERT_TRUE(write_demo_recording(options, folder.path(name), [](double) { return true; }));
  }
  EXPECT_FALSE(folder.read("a/v1.mcap").empty());
  EXPECT_TRUE(folder.read("a/v1.mcap") == folder.read("b/v1.mcap"));
  EXPECT_EQ(folder.read("a/fleet.yaml"), folder.read("b/fleet.yaml"));
}

TEST(DemoRecording, leaves_no_recording_when_it_is_stopped) {
  const io::TestFolder folder;
  const auto made =
      write_demo_recording(short_drive(), folder.path(), [](double share) { return share < 0.5; });
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kInterrupted);
  EXPECT_TRUE(folder.read("v1.mcap").empty());
}

}  // namespace
}  // namespace rali::cli
