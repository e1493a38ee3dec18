#include <cmath>
#include <filesystem>
#include <stdexcept>

#include <gtest/gtest.h>

#include "rali/drive/hall_recording_for_test.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/rali.hpp"

namespace rali::api_io {
namespace {

/// A vehicle in a hall for a few seconds, mapped once for all tests that need results.
class MappedHall : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new io::TestFolder;
    drive::test::HallRecording hall;
    hall.duration_s = 4.0;
    ASSERT_FALSE(hall.write(folder_->path("v1.bag")).empty());
    summary_ = map_recordings(config(), options("out"));
  }

  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static FleetConfig config() {
    return load_inputs({folder_->path("v1.bag")}, {"", {{"vehicles.v1.lidar.time_offset_s", "0"}}});
  }

  static MapOptions options(const std::string& out) {
    MapOptions options;
    options.out = folder_->path(out);
    options.threads = 1;
    return options;
  }

  static io::TestFolder* folder_;
  static MapSummary summary_;
};

io::TestFolder* MappedHall::folder_ = nullptr;
MapSummary MappedHall::summary_;

TEST_F(MappedHall, summary_agrees_with_the_written_files) {
  EXPECT_EQ(summary_.status, MapStatus::kComplete);
  ASSERT_EQ(summary_.vehicles.size(), 1U);
  EXPECT_EQ(summary_.vehicles[0].name, "v1");
  const Trajectory trajectory = read_trajectory(folder_->path("out/trajectory/v1.tum"));
  EXPECT_EQ(trajectory.size(), summary_.vehicles[0].scans);
  ASSERT_EQ(trajectory.covariances.size(), trajectory.size());
  EXPECT_GT(trajectory.covariances.back()(0, 0), 0.0);
  EXPECT_EQ(trajectory.covariances.back()(0, 1), trajectory.covariances.back()(1, 0));
  const MapCloud map = read_map(folder_->path("out/map.pcd"));
  EXPECT_EQ(map.size(), summary_.map_points);
  EXPECT_EQ(map.sigma_m.size(), map.size());
  EXPECT_EQ(read_map(folder_->path("out/map.ply")).sigma_m, map.sigma_m);
  EXPECT_TRUE(std::filesystem::exists(folder_->path("out/report.html")));
}

TEST_F(MappedHall, stepping_by_hand_gives_the_odometry_of_the_run) {
  RecordingReader reader(config());
  Vehicle vehicle(reader.vehicle_options());
  const Trajectory odometry = read_trajectory(folder_->path("out/odometry/v1.tum"));
  std::size_t n = 0;
  while (std::optional<Event> event = reader.next()) {
    for (const Output& output : vehicle.step(std::move(*event))) {
      const auto* pose = std::get_if<PoseEstimate>(&output);
      if (pose == nullptr) continue;
      ASSERT_LT(n, odometry.size());
      EXPECT_EQ(pose->stamp_ns, odometry.stamp_ns[n]);
      EXPECT_TRUE(pose->T_odom_body.isApprox(odometry.poses[n], 1e-5)) << n;
      EXPECT_NEAR(pose->covariance(0, 0) / odometry.covariances[n](0, 0), 1.0, 1e-5);
      ++n;
    }
  }
  EXPECT_EQ(n, odometry.size());
  EXPECT_EQ(reader.progress(), 1.0);
}

TEST_F(MappedHall, a_trajectory_compared_with_itself_has_no_error) {
  EvaluateOptions options;
  options.truth = folder_->path("out/trajectory/v1.tum");
  options.out = folder_->path("judged");
  const Evaluation evaluation = evaluate(folder_->path("out/trajectory/v1.tum"), options);
  ASSERT_EQ(evaluation.vehicles.size(), 1U);
  EXPECT_GT(evaluation.fleet.ape_m.count, 10U);
  EXPECT_LT(evaluation.fleet.ape_m.max, 1e-6);
  EXPECT_THROW((void)evaluate(folder_->path("out/trajectory/v1.tum"), {}), SettingsError);
}

TEST_F(MappedHall, an_exception_in_a_callback_propagates_and_marks_the_run_interrupted) {
  MapCallbacks callbacks;
  callbacks.progress = [](const MapProgress& p) -> bool {
    if (p.stage == "odometry") throw std::out_of_range("enough");
    return true;
  };
  EXPECT_THROW((void)map_recordings(config(), options("thrown"), callbacks), std::out_of_range);
  EXPECT_NE(folder_->read("thrown/status.json").find("\"interrupted\""), std::string::npos);
}

TEST_F(MappedHall, a_callback_can_stop_the_run) {
  MapCallbacks callbacks;
  callbacks.progress = [](const MapProgress& p) { return p.stage != "odometry"; };
  const MapSummary summary = map_recordings(config(), options("stopped"), callbacks);
  EXPECT_EQ(summary.status, MapStatus::kInterrupted);
}

TEST_F(MappedHall, a_folder_with_results_is_refused_as_by_the_command_line) {
  EXPECT_THROW((void)map_recordings(config(), options("out")), SettingsError);
}

TEST(Config, an_unknown_key_is_named_in_the_error) {
  try {
    (void)load_inputs({"a.bag"}, {"", {{"output.map_voxel", "0.1"}}});
    FAIL() << "the key was taken";
  } catch (const SettingsError& error) {
    EXPECT_EQ(error.where(), "settings");
    EXPECT_NE(error.problem().find("'output.map_voxel'"), std::string::npos) << error.what();
  }
}

TEST(Config, settings_of_one_vehicle_change_its_estimates) {
  VehicleOptions paper = with_settings({}, {"paper", {}});
  EXPECT_NE(Vehicle(paper).state_hash(), Vehicle(VehicleOptions{}).state_hash());
  EXPECT_THROW((void)with_settings({}, {"best", {}}), SettingsError);
}

TEST(Results, a_table_of_ranges_has_nan_where_a_cell_is_empty) {
  const io::TestFolder folder;
  const std::string path = folder.write("ranges.csv",
                                        "stamp_s,from,to,range_m,predicted_m,used,reason\n"
                                        "1700000000.021266514,v1,v2,2.4160,,0,no_pose\n"
                                        "1700000000.070763272,v1,tag9,2.3920,2.4,1,used\n");
  const RangeTable table = read_ranges(path);
  ASSERT_EQ(table.size(), 2U);
  EXPECT_EQ(table.stamp_ns[0], 1700000000021266514);
  EXPECT_TRUE(std::isnan(table.predicted_m[0]));
  EXPECT_EQ(table.to[1], "tag9");
  EXPECT_EQ(table.used[1], 1);
  EXPECT_TRUE(std::isnan(table.bias_m[1]));
  EXPECT_THROW((void)read_ranges(folder.path("none.csv")), InputError);
}

}  // namespace
}  // namespace rali::api_io
