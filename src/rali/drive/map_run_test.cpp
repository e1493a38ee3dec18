#include "rali/drive/map_run.hpp"

#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/base/internal_error.hpp"
#include "rali/drive/hall_recording_for_test.hpp"
#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/io/files/tum.hpp"
#include "rali/io/message_source.hpp"

namespace rali::drive {
namespace {

class SilentSink final : public ProgressSink {
 public:
  void progress(const Progress& /*progress*/) override {}

  void finding(const Finding& /*finding*/) override {}
};

/// A run over a short drive whose settings cannot be written because of an internal fault.
MapJob faulty_job(const io::TestFolder& folder) {
  test::HallRecording recording;
  recording.duration_s = 1.0;
  MapJob job;
  job.vehicles.emplace_back();
  job.vehicles.back().inputs = {recording.write(folder.path("v1.bag"))};
  job.out_dir = folder.path("out");
  job.write_mcap = false;
  job.settings_text = [](const std::vector<InputReport>& /*reports*/) -> std::string {
    throw InternalError("x > 0 at somewhere.cpp:7");
  };
  return job;
}

TEST(MapRun, an_internal_error_leaves_a_log_and_the_status_failed) {
  const io::TestFolder folder;
  SilentSink sink;
  const std::atomic<bool> stop{false};
  EXPECT_THROW(static_cast<void>(run_map(faulty_job(folder), sink, stop)), InternalError)
      << "the caller makes exit code 5 of it";
  const std::string log = folder.read("out/run.log");
  EXPECT_NE(log.find("internal fault: x > 0 at somewhere.cpp:7"), std::string::npos) << log;
  const auto status = nlohmann::json::parse(folder.read("out/status.json"));
  EXPECT_EQ(status["status"], "failed");
  EXPECT_TRUE(status["files"].contains("trajectory/v1.tum")) << "what is whole is kept";
}

TEST(MapRun, a_missing_input_creates_no_output_folder) {
  const io::TestFolder folder;
  MapJob job = faulty_job(folder);
  job.vehicles.front().inputs = {folder.path("none.bag")};
  SilentSink sink;
  const std::atomic<bool> stop{false};
  EXPECT_FALSE(run_map(job, sink, stop));
  EXPECT_FALSE(std::filesystem::exists(folder.path("out")));
}

geometry::Vec3 on_site(const geometry::Vec3& p_hall_m) {
  return geometry::rotation_from_rpy(0.0, 0.0, 2.0) * p_hall_m +
         geometry::Vec3(691600.0, 5335800.0, 500.0);
}

/// A drive through the hall with all outputs that are off by default.
MapJob full_job(const io::TestFolder& folder) {
  test::HallRecording recording;
  recording.duration_s = 9.0;
  MapJob job;
  job.vehicles.emplace_back();
  job.vehicles.back().input.vehicle = "v1";
  job.vehicles.back().inputs = {recording.write(folder.path("v1.bag"))};
  job.vehicles.back().input.T_body_lidar = geometry::SE3{};
  job.out_dir = folder.path("out");
  job.imu_rate = true;
  for (const double t_s : {0.5, 4.0, 6.0, 8.5}) {
    job.marks.push_back({VehicleId{0}, Time::from_s(test::HallRecording::kStart_s + t_s),
                         on_site(test::HallRecording::pose(t_s).p), 0.05});
  }
  return job;
}

TEST(MapRun, writes_georeference_imu_rate_trajectory_and_diagnostics) {
  const io::TestFolder folder;
  SilentSink sink;
  const std::atomic<bool> stop{false};
  const auto summary = run_map(full_job(folder), sink, stop);
  ASSERT_TRUE(summary) << summary.error().message();
  const auto metrics = nlohmann::json::parse(folder.read("out/metrics.json"));
  ASSERT_TRUE(metrics.contains("site")) << metrics["warnings"].dump();
  EXPECT_LT(metrics["site"]["rms_m"].get<double>(), 0.06);
  EXPECT_EQ(metrics["site"]["marks"].size(), 4U);
  EXPECT_EQ(metrics["vehicles"]["v1"]["T_map_odom"]["cov"].size(), 21U);
  const auto las = io::read_cloud_file(folder.path("out/map.las"));
  ASSERT_TRUE(las) << las.error().message();
  ASSERT_GT(las->size(), 1000U);
  EXPECT_EQ(las->size(), summary->map_points);
  const geometry::Vec3 site_m = on_site({11.0, 6.5, 2.5});  // the middle of the hall
  const std::vector<double> x_m = las->column(las->field("x")), y_m = las->column(las->field("y"));
  for (const double x : {x_m.front(), x_m.back()}) EXPECT_NEAR(x, site_m.x(), 14.0);
  for (const double y : {y_m.front(), y_m.back()}) EXPECT_NEAR(y, site_m.y(), 14.0);
  const auto fine = io::read_tum(folder.path("out/trajectory/v1.imu.tum"));
  const auto scans = io::read_tum(folder.path("out/trajectory/v1.tum"));
  ASSERT_TRUE(fine && scans);
  EXPECT_GT(fine->poses.size(), 15 * scans->poses.size()) << "200 Hz beside 10 Hz";
  const auto session = io::open_recording(folder.path("out/session.mcap"));
  ASSERT_TRUE(session);
  const auto diagnostics =
      std::find_if((*session)->topics().begin(), (*session)->topics().end(),
                   [](const io::Topic& topic) { return topic.name == "/diagnostics"; });
  ASSERT_NE(diagnostics, (*session)->topics().end());
  EXPECT_EQ(diagnostics->type, "diagnostic_msgs/msg/DiagnosticArray");
  EXPECT_GE(diagnostics->messages.value_or(0), 6U) << "once a second";
}

TEST(MapRun, trajectory_is_that_of_the_configured_point) {
  const io::TestFolder folder;
  MapJob job = full_job(folder);
  job.marks.clear();
  job.write_mcap = false;
  SilentSink sink;
  const std::atomic<bool> stop{false};
  ASSERT_TRUE(run_map(job, sink, stop));
  job.out_dir = folder.path("lidar");
  job.point = OutputPoint::kLidar;
  job.vehicles.front().input.T_body_lidar = geometry::SE3{geometry::Mat3::Identity(), {0, 0, 0.5}};
  ASSERT_TRUE(run_map(job, sink, stop));
  const auto body = io::read_tum(folder.path("out/trajectory/v1.tum"));
  const auto lidar = io::read_tum(folder.path("lidar/trajectory/v1.tum"));
  ASSERT_TRUE(body && lidar);
  EXPECT_EQ(lidar->header.front(), "T_map_lidar: pose of lidar of v1 in map");
  EXPECT_NEAR(lidar->poses.front().T.p.z(), 0.5, 0.05);
  EXPECT_NEAR(body->poses.front().T.p.z(), 0.0, 0.05);
}

TEST(MapRun, the_mounting_of_a_tilted_lidar_is_found_by_its_turning) {
  const io::TestFolder folder;
  test::HallRecording recording;
  recording.R_body_lidar = geometry::rotation_from_rpy(0.0, 0.4, 0.0);
  MapJob job = faulty_job(folder);
  job.vehicles.front().inputs = {recording.write(folder.path("tilted.bag"))};
  job.settings_text = {};
  SilentSink sink;
  const std::atomic<bool> stop{false};
  const auto summary = run_map(job, sink, stop);
  ASSERT_TRUE(summary) << summary.error().message();
  const InputReport& input = summary->vehicles.front().input;
  EXPECT_EQ(input.T_body_lidar_origin, "turning");
  const geometry::Mat3 off = input.T_body_lidar.R.transpose() * recording.R_body_lidar;
  EXPECT_LT(geometry::so3_log(off).norm(), 0.03);
}

}  // namespace
}  // namespace rali::drive
