#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "rali/cli/command.hpp"
#include "rali/cli/map_summary.hpp"
#include "rali/cli/progress_view.hpp"
#include "rali/config/load_fleet.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/jobs/map_job.hpp"

namespace rali::cli {
namespace {

config::FleetConfig fleet_of(std::string_view text) {
  const auto fleet = config::parse_fleet(text, "fleet.yaml", "", {});
  EXPECT_TRUE(fleet) << fleet.error().message();
  return fleet ? *fleet : config::FleetConfig{};
}

drive::MapSummary summary_of(std::size_t vehicles) {
  drive::MapSummary summary;
  summary.out_dir = "out";
  summary.checks = {43, 40, 0};
  for (std::size_t i = 0; i < vehicles; ++i) {
    drive::VehicleSummary vehicle;
    vehicle.name = "v" + std::to_string(i + 1);
    vehicle.path_m = 512.0 - 14.0 * static_cast<double>(i);
    vehicle.keyframes = 602;
    vehicle.degenerate_fraction = i == 0 ? 0.08 : 0.27;
    vehicle.sigma_median_m = 0.06;
    vehicle.sigma_max_m = i == 0 ? 0.2 : 0.31;
    vehicle.input.t_start = Time::from_s(1000.0);
    vehicle.t_sigma_max = Time::from_s(1388.0);
    summary.vehicles.push_back(vehicle);
    const VehicleId id{static_cast<std::uint16_t>(i)};
    summary.fleet.groups.push_back({id});
    summary.fleet.frames.emplace_back().vehicle = id;
    summary.fleet.frames.back().group = i;
  }
  return summary;
}

TEST(MapJob, takes_its_options_from_the_fleet_file) {
  const config::FleetConfig fleet = fleet_of(
      "vehicles:\n  v1:\n    recording: a.bag\n    start_s: 3\n"
      "    lidar: {topic: /p, point_time: azimuth, header_stamp: end, range_m: [1, 50],\n"
      "            T_body_lidar: {xyz_m: [0, 0, 1]}, time_offset_s: 0.02}\n"
      "    imu: {topic: none, accel_unit: g, model: bmi088}\n"
      "    self_box_m: [-1, 1, -2, 2, 0, 1]\n"
      "output: {map_voxel_m: 0.2}\nsettings: {checks: {extrinsics: off}}\n");
  const auto job = jobs::make_map_job(fleet, jobs::MapOptions{});
  ASSERT_TRUE(job) << job.error().message();
  const drive::VehicleJob& v1 = job->vehicles.at(0);
  EXPECT_EQ(v1.inputs.at(0), "a.bag");
  EXPECT_EQ(v1.input.lidar_topic, "/p");
  EXPECT_EQ(v1.input.cloud.point_time, wire::PointTime::kAzimuth);
  EXPECT_EQ(v1.input.cloud.header_stamp, wire::HeaderStamp::kEnd);
  EXPECT_EQ(v1.input.start_s, 3.0);
  EXPECT_EQ(v1.input.accel_unit, drive::AccelUnit::kG);
  EXPECT_EQ(v1.input.extrinsics, drive::ExtrinsicsCheck::kOff);
  EXPECT_FALSE(v1.settings.has_imu);
  EXPECT_EQ(v1.input.lidar_time_offset.value_s, 0.02);
  EXPECT_NEAR(v1.settings.odometry.imu_noise.accel_mps2_rthz, 175.0 * 9.80665e-6, 1e-9);
  EXPECT_EQ(job->map.voxel_m, 0.2);
  // The LiDAR is 1 m up: the box of the body is 1 m down in its axes.
  ASSERT_TRUE(v1.input.cloud.self_box_lidar_m);
  EXPECT_EQ((*v1.input.cloud.self_box_lidar_m)[4], -1.0);
  EXPECT_EQ((*v1.input.cloud.self_box_lidar_m)[5], 0.0);
  EXPECT_EQ((*v1.input.cloud.self_box_lidar_m)[3], 2.0);
}

TEST(MapJob, refuses_a_self_box_without_extrinsics_and_a_missing_georeference_file) {
  const auto error_of = [](std::string_view text) {
    const auto job = jobs::make_map_job(fleet_of(text), jobs::MapOptions{});
    return job ? std::string() : job.error().message();
  };
  EXPECT_NE(error_of("vehicles: {v1: {recording: a, self_box_m: [0, 1, 0, 1, 0, 1]}}"), "");
  EXPECT_NE(error_of("vehicles: {v1: {recording: a}}\noutput: {georeference: /none.csv}")
                .find("/none.csv: there is no such file. It is named at fleet.yaml:2"),
            std::string::npos);
}

TEST(MapJob, takes_lidar_returns_output_point_and_georeference_marks) {
  const io::TestFolder folder;
  const std::string marks =
      folder.write("marks.csv",
                   "vehicle,stamp_s,x_m,y_m,z_m,sigma_m\nv1,1,2,3,4,0.1\nv1,2,2,3,4,0.1\n"
                   "v1,3,2,3,4,0.1\n");
  const auto job =
      jobs::make_map_job(fleet_of("vehicles: {v1: {recording: a, lidar: {returns: last}}}\n"
                                  "output: {frame: lidar, georeference: " +
                                  marks + "}\n"),
                         jobs::MapOptions{});
  ASSERT_TRUE(job) << job.error().message();
  EXPECT_EQ(job->vehicles[0].input.cloud.returns, wire::Returns::kLast);
  EXPECT_EQ(job->point, drive::OutputPoint::kLidar);
  EXPECT_EQ(job->marks.size(), 3U);
}

TEST(MapJob, refuses_missing_or_invalid_range_files_before_computing) {
  const io::TestFolder folder;
  const std::string good = folder.write("good.csv", "stamp_s,from,to,range_m\n1,v1,v2,3\n");
  const std::string bad = folder.write("bad.csv", "stamp_s,from\n1,v1\n");
  const auto error_of = [](const std::string& more) {
    const auto job =
        jobs::make_map_job(fleet_of("vehicles: {v1: {recording: a}}\n" + more), jobs::MapOptions{});
    return job ? std::string() : job.error().message();
  };
  EXPECT_EQ(error_of("ranges: {sources: [{file: " + good + "}]}\n"), "");
  EXPECT_NE(error_of("ranges: {sources: [{file: " + good + "}, {file: /none.csv}]}\n")
                .find("/none.csv: there is no such file. It is named at fleet.yaml:2"),
            std::string::npos);
  EXPECT_NE(error_of("ranges: {sources: [{file: " + folder.path() + "}]}\n").find("is a folder"),
            std::string::npos);
  EXPECT_NE(error_of("ranges: {sources: [{file: " + bad + "}]}\n"), "");
  EXPECT_NE(error_of("ranges: {sources: [{serial_log: " + good + ", vehicle: v1}]}\n")
                .find("Record rows of `stamp_s,hex`"),
            std::string::npos);
  EXPECT_NE(error_of("radio: {file: /none.csv}\n"), "");
  EXPECT_NE(error_of("radio: {file: " + good + "}\n"), "") << "no column rssi_dbm";
  EXPECT_NE(error_of("rounds: /none.csv\n"), "");
}

TEST(MapJob, names_the_keys_that_have_no_effect) {
  const auto idle = jobs::idle_keys(fleet_of(
      "vehicles: {v1: {recording: a, antennas: {u: {xyz_m: [0, 0, 1]}}}}\nclock: offset\n"));
  EXPECT_EQ(idle, (std::vector<std::string>{"clock", "vehicles.v1.antennas"}));
  const auto two = jobs::idle_keys(fleet_of(
      "vehicles: {v1: {recording: a, antennas: {u: {xyz_m: [0, 0, 1]}}}, v2: {recording: b}}\n"
      "clock: separate\nranges: {sigma_m: 0.2}\nradio: {file: r.csv}\nrounds: off\n"));
  EXPECT_EQ(two, (std::vector<std::string>{"radio.file"})) << "without rounds it says nothing";
  EXPECT_TRUE(jobs::idle_keys(fleet_of("vehicles: {v1: {recording: a}}")).empty());
}

TEST(MapJob, its_settings_contain_the_detected_values_and_load_again) {
  const auto job =
      jobs::make_map_job(fleet_of("vehicles: {v1: {recording: a.bag}}"), jobs::MapOptions{});
  ASSERT_TRUE(job);
  drive::InputReport report;
  report.vehicle = "v1";
  report.lidar_topic = "/points";
  report.T_body_lidar.p = geometry::Vec3(0.1, 0.0, 0.2);
  report.T_body_lidar_origin = "/tf_static";
  const std::string text = job->settings_text({report});
  EXPECT_NE(text.find("topic: /points"), std::string::npos) << text;
  EXPECT_NE(text.find("# found: /tf_static"), std::string::npos);
  EXPECT_NE(text.find("recording: ../a.bag"), std::string::npos);
  const config::FleetConfig again = fleet_of(text);
  ASSERT_EQ(again.vehicles.size(), 1U);
  EXPECT_EQ(again.vehicles[0].lidar.T_body_lidar.T.p.z(), 0.2);
}

TEST(MapJob, its_settings_note_the_estimated_latency_and_keep_it_auto) {
  const auto job = jobs::make_map_job(
      fleet_of("vehicles: {v1: {recording: a}, v2: {recording: b}}"), jobs::MapOptions{});
  ASSERT_TRUE(job);
  drive::InputReport report;
  report.vehicle = "v1";
  report.range_latency = drive::RangeLatency{0.046, 0.005};
  const std::string text = job->settings_text({report});
  const std::size_t line = text.find("latency_s: auto");
  ASSERT_NE(line, std::string::npos) << text;
  EXPECT_NE(text.find("# found: 46 ms, sigma 5.0 ms, by motion\n", line), std::string::npos)
      << text.substr(line, 120);
  EXPECT_FALSE(fleet_of(text).ranges.latency_s) << "a rerun gives the same";
}

TEST(MapSummary, summarises_the_run_in_a_few_lines) {
  EXPECT_EQ(summary_text(summary_of(2), "out/report.html"),
            "out/report.html\n2 vehicles, each in a frame of its own\n"
            "path 512 + 498 m, 1204 keyframes, 0 map points\n"
            "degenerate: v1 8 %, v2 27 % of the distance travelled\n"
            "expected position error (1 sigma): median 0.06 m, worst 0.31 m (v2, 388 s)\n"
            "check: 40 of 43 keyframes see enough walls to contradict the map; no contradiction\n"
            "gaps: none\n");
  drive::MapSummary unseen = summary_of(2);
  unseen.checks.keyframes_checked = 0;
  EXPECT_NE(summary_text(unseen, "out")
                .find("check: no keyframe sees enough walls to contradict the map\n"
                      "gaps: none in the data\n"),
            std::string::npos)
      << "what was not looked at is not stated to be right";
  drive::MapSummary joined = summary_of(2);
  joined.fleet.groups = {{VehicleId{0}, VehicleId{1}}};
  joined.fleet.frames[1].group = 0;
  joined.fleet.frames[1].decided_by = fleet::DecidedBy::kPrior;
  joined.fleet.frames[1].sigma_m = 0.04;
  joined.fleet.frames[1].sigma_rad = 0.0035;
  joined.fleet.loops.resize(4);
  for (std::size_t i = 0; i < 3; ++i) joined.fleet.loops[i].accepted = true;
  const std::string text = summary_text(joined, "out");
  EXPECT_NE(
      text.find("\n2 vehicles in one frame (v2 placed by the prior, sigma 0.04 m, 0.2 deg)\n"),
      std::string::npos)
      << text;
  EXPECT_NE(text.find(", 3 loops closed, 1 refused\n"), std::string::npos) << text;
  joined.fleet.frames[1].sigma_rad = 22.4;
  EXPECT_NE(summary_text(joined, "out").find("sigma 0.04 m, heading unknown)\n"), std::string::npos)
      << "a vehicle that stands is placed by ranges without a heading";
  drive::MapSummary damaged = summary_of(1);
  damaged.vehicles[0].input.gaps.jumps = 2;
  damaged.vehicles[0].diverged_s = 3.0;
  EXPECT_NE(summary_text(damaged, "out")
                .find("gaps: v1: 2 clock jumps closed, 3.0 s cut out where the odometry diverged"),
            std::string::npos);
}

TEST(MapSummary, reports_the_distance_constrained_by_ranges_and_rejection_reasons) {
  drive::MapSummary summary = summary_of(2);
  const auto count = [&](ranging::RangeReason reason, std::size_t n) {
    summary.ranges.by_reason[static_cast<std::size_t>(reason)] = n;
    summary.ranges.total += n;
  };
  count(ranging::RangeReason::kUsed, 9602);
  count(ranging::RangeReason::kNoPose, 25);
  count(ranging::RangeReason::kNlos, 412);
  count(ranging::RangeReason::kOutlier, 201);
  summary.vehicles[1].degenerate_held_fraction = 0.5;
  const std::string text = summary_text(summary, "out");
  // 0.5 * 0.27 * 498 m of 0.08 * 512 m + 0.27 * 498 m
  EXPECT_NE(text.find("degenerate: v1 8 %, v2 27 % of the distance travelled; constrained by "
                      "ranges 38 % of it\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("ranges: 9602 used, 638 rejected (412 nlos, 201 outlier, 25 no pose)\n"),
            std::string::npos)
      << text;
}

TEST(MapSummary, names_the_anchors_of_the_first_12_rounds) {
  drive::MapSummary summary = summary_of(2);
  EXPECT_EQ(summary_text(summary, "out").find("round"), std::string::npos);
  summary.rounds.resize(3);
  summary.rounds[1].anchor = VehicleId{1};
  EXPECT_NE(summary_text(summary, "out").find("\n3 rounds, anchors v1 v2 v1\n"), std::string::npos)
      << summary_text(summary, "out");
  summary.rounds.resize(40);
  EXPECT_NE(summary_text(summary, "out")
                .find("\n40 rounds, anchors v1 v2 v1 v1 v1 v1 v1 v1 v1 v1 v1 v1 ...\n"),
            std::string::npos);
}

TEST(MapSummary, the_exit_code_follows_from_status_and_gaps) {
  drive::MapSummary summary = summary_of(1);
  EXPECT_EQ(exit_code_of(summary, 0), 0);
  summary.gaps = true;
  EXPECT_EQ(exit_code_of(summary, 0), 3);
  summary.gaps = false;
  summary.status = drive::RunStatus::kPartial;
  EXPECT_EQ(exit_code_of(summary, 0), 3);
  summary.status = drive::RunStatus::kInterrupted;
  EXPECT_EQ(exit_code_of(summary, 2), 130);
  EXPECT_EQ(exit_code_of(summary, 15), 143);
}

TEST(MapSummary, violated_requirements_are_named) {
  const auto requirements = parse_requirements({"connected", "max_sigma_m=0.25"});
  ASSERT_TRUE(requirements);
  const auto broken = broken_requirements(*requirements, summary_of(2));
  ASSERT_EQ(broken.size(), 2U);
  EXPECT_EQ(broken[1], "required max_sigma_m=0.25: v2 reaches 0.31 m");
  EXPECT_TRUE(broken_requirements(*requirements, summary_of(1)).empty());
  const auto loops = broken_requirements(*parse_requirements({"min_loops=1"}), summary_of(1));
  EXPECT_EQ(loops, (std::vector<std::string>{"required min_loops=1: 0 loops closed"}));
  EXPECT_FALSE(parse_requirements({"max_sigma_m=-1"}));
  EXPECT_FALSE(parse_requirements({"connected=1"}));
  EXPECT_FALSE(parse_requirements({""}));
}

TEST(ErrorCodes, map_to_the_documented_exit_codes) {
  EXPECT_EQ(exit_code_of(Error{ErrorCode::kUsage, "", "", ""}, 0), 2);
  EXPECT_EQ(exit_code_of(Error{ErrorCode::kInput, "", "", ""}, 0), 2);
  EXPECT_EQ(exit_code_of(Error{ErrorCode::kMachine, "", "", ""}, 0), 4);
  EXPECT_EQ(exit_code_of(Error{ErrorCode::kInterrupted, "", "", ""}, 15), 143);
}

TEST(Progress, a_line_has_bar_speed_distance_and_remaining_time) {
  drive::Progress progress;
  progress.vehicle = "v1";
  progress.fraction = 0.62;
  progress.speed = 6.4;
  progress.path_m = 312.0;
  progress.degenerate_fraction = 0.08;
  progress.stage = "odometry";
  EXPECT_EQ(progress_line(progress, true, 41.0),
            "v1 [#########-----]  62 %  6.4x  312 m  degenerate  8 %  ETA 0:41");
  EXPECT_EQ(progress_line(progress, false, -1.0), "v1  62 %  6.4x  312 m  degenerate  8 %");
  EXPECT_EQ(progress_line(progress, false, 4000.0).substr(38), "  ETA 1:06:40");
  progress.ranges = 5120;
  progress.ranges_used = 4812;
  EXPECT_EQ(progress_line(progress, false, -1.0),
            "v1  62 %  6.4x  312 m  degenerate  8 %  ranges 4812/5120");
  progress.fraction = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(progress_line(progress, true, -1.0).substr(0, 24), "v1 [--------------]   0 ");
}

TEST(Progress, without_a_terminal_prints_one_line_per_10_percent) {
  testing::internal::CaptureStderr();
  {
    Session session;
    ProgressView view(session);
    drive::Progress progress;
    progress.vehicle = "v1";
    progress.stage = "odometry";
    for (int i = 0; i <= 1000; ++i) {
      progress.fraction = i / 1000.0;
      view.progress(progress);
    }
  }
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 10) << text;
  EXPECT_EQ(text.find('\033'), std::string::npos);
}

TEST(Progress, as_json_is_one_object_per_line_even_with_invalid_utf8) {
  testing::internal::CaptureStderr();
  {
    Session session;
    session.options.progress = "json";
    ProgressView view(session);
    drive::Progress progress;
    progress.vehicle = "v\xff\"1";
    progress.stage = "map";
    progress.fraction = 0.5;
    view.progress(progress);
    Finding finding;
    finding.text = "line\nend";
    view.finding(finding);
  }
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;
  EXPECT_EQ(text.front(), '{');
}

TEST(Progress, many_warnings_of_one_kind_do_not_hide_the_others) {
  testing::internal::CaptureStderr();
  {
    Session session;
    ProgressView view(session);
    Finding finding;
    finding.vehicle = "v1";
    finding.id = "monitor.walls";
    finding.text = "walls are looked through";
    for (int i = 0; i < 20; ++i) view.finding(finding);
    finding.id = "D10";
    finding.text = "a gap in the inertial data";
    view.finding(finding);
  }
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5) << text;
  EXPECT_NE(text.find("v1: more of monitor.walls: see metrics.json."), std::string::npos) << text;
  EXPECT_NE(text.find("a gap in the inertial data"), std::string::npos) << text;
}

TEST(Findings, are_reported_with_effect_and_remedy) {
  Finding finding;
  finding.vehicle = "v1";
  finding.topic = "/imu";
  finding.text = "unit is g";
  finding.remedy = "Nothing to do";
  EXPECT_EQ(finding_line(finding), "v1 /imu: unit is g. Nothing to do.");
}

}  // namespace
}  // namespace rali::cli
