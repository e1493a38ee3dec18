#include "rali/drive/recording_events.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/drive/fake_recording_for_test.hpp"

namespace rali::drive {
namespace {

InputOptions with_ranges() {
  auto ranges = std::make_shared<RangeOptions>();
  ranges->names = {{"v1", {VehicleId{0}, 0}}, {"v2", {VehicleId{1}, 0}}};
  ranges->antennas = {1, 1};
  ranges->topics = {{"/ranges", {}}};
  InputOptions options;
  options.ranges = ranges;
  return options;
}

TEST(RecordingEvents, ranges_of_a_named_topic_are_merged_without_changing_other_events) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 4.0, as_is);
  recording.add_range(1003.905, 1003.92);  // 65 ms late, with all sensor data beside it
  recording.add_seconds(1004.0, 2.0, as_is);
  recording.add_range(1004.005, 1006.0);  // 2 s late
  recording.add_seconds(1006.0, 1.0, as_is);
  const std::string file = recording.save(folder);
  const auto source = open_recording_events({file}, with_ranges());
  ASSERT_TRUE(source) << source.error().message();
  const Drained d = drain(**source);
  EXPECT_EQ(d.ranges, (std::vector<Time>{Time::from_s(1003.905), Time::from_s(1004.005)}));
  EXPECT_FALSE(d.ordered) << "the late one comes with its own time, to be refused by it";
  EXPECT_EQ((*source)->report().ranges, 2U);
  EXPECT_EQ((*source)->report().range_messages.at("/ranges"), 2U);
  const auto plain = open_recording_events({file}, {});
  ASSERT_TRUE(plain);
  const Drained p = drain(**plain);
  EXPECT_TRUE(p.ranges.empty()) << "a topic that no source names is not read";
  EXPECT_EQ(p.scans, d.scans);
  EXPECT_EQ(p.imu, d.imu);
  EXPECT_EQ((*source)->report().gaps.late, (*plain)->report().gaps.late);
}

TEST(RecordingEvents, ranges_stamped_by_the_recorder_are_converted_to_the_sensor_clock) {
  const io::TestFolder folder;
  FakeRecording recording;
  const auto boot_clock = [](double t, bool /*imu*/) { return t - 900.0; };
  recording.add_seconds(1000.0, 5.0, boot_clock);
  recording.add_range(0.0, 1002.0);
  recording.add_seconds(1005.0, 1.0, boot_clock);
  const auto source = open_recording_events({recording.save(folder)}, with_ranges());
  ASSERT_TRUE(source) << source.error().message();
  const Drained d = drain(**source);
  ASSERT_EQ(d.ranges.size(), 1U);
  const double offset_s = (*source)->report().lidar_stamp == "header" ? -900.0 : 0.0;
  EXPECT_NEAR(d.ranges[0].s(), 1002.0 + offset_s, 0.2);
}

TEST(RecordingEvents, returns_every_event_once_and_in_order) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 6.0, as_is);
  const auto source = open_recording_events({recording.save(folder)}, {});
  ASSERT_TRUE(source) << source.error().message();
  const Drained d = drain(**source);
  EXPECT_EQ(d.scans, 60U);
  EXPECT_EQ(d.imu, 600U);
  EXPECT_TRUE(d.ordered);
  const InputReport& report = (*source)->report();
  EXPECT_EQ(report.lidar_topic, "/points");
  EXPECT_EQ(report.imu_topic, "/imu");
  EXPECT_TRUE(report.has_imu);
  EXPECT_EQ(report.gaps.late + report.gaps.jumps + report.gaps.repeated, 0U);
  EXPECT_FALSE(report.gaps.damaged);
  EXPECT_NEAR(d.last_scan.s(), 1005.99, 2e-3);
}

TEST(RecordingEvents, applies_start_duration_and_the_lidar_time_offset) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 6.0, as_is);
  InputOptions options;
  options.start_s = 2.0;
  options.duration_s = 1.0;
  options.lidar_time_offset.value_s = 0.025;
  const auto source = open_recording_events({recording.save(folder)}, options);
  ASSERT_TRUE(source);
  const Drained d = drain(**source);
  EXPECT_NEAR(d.first.s(), 1002.0, 1e-6);
  EXPECT_LE(d.last.s(), 1003.0 + 1e-6);
  EXPECT_NEAR(static_cast<double>(d.scans), 10.0, 1.0);
  EXPECT_NEAR(std::fmod(d.first_scan.s() - 1000.0, 0.1), 0.015, 2e-3) << "0.09 + 0.025 s";
}

TEST(RecordingEvents, adds_the_clock_offset_to_all_stamps_of_the_vehicle) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 4.0, as_is);
  recording.add_range(1003.905, 1003.92);
  recording.add_seconds(1004.0, 1.0, as_is);
  const std::string file = recording.save(folder);
  InputOptions options = with_ranges();
  options.self = VehicleId{1};
  const auto plain = open_recording_events({file}, options);
  options.clock_offset.value_s = -12.5;
  const auto moved = open_recording_events({file}, options);
  ASSERT_TRUE(plain && moved);
  const Drained p = drain(**plain), m = drain(**moved);
  const Duration offset = Duration::from_s(-12.5);
  EXPECT_EQ(m.first, p.first + offset) << "an inertial sample";
  EXPECT_EQ(m.first_scan, p.first_scan + offset);
  EXPECT_EQ(m.last_scan, p.last_scan + offset);
  EXPECT_EQ(m.ranges, (std::vector<Time>{Time::from_s(1003.905) + offset}));
  EXPECT_EQ(m.scans, p.scans);
  EXPECT_EQ((*moved)->report().t_start, (*plain)->report().t_start + offset);
  EXPECT_EQ((*moved)->report().clock_offset.value_s, -12.5);
}

TEST(RecordingEvents, removes_a_common_clock_jump_of_both_sensors) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 8.0, [](double t, bool) { return t < 1005.0 ? t : t + 500.0; });
  const auto source = open_recording_events({recording.save(folder)}, {});
  ASSERT_TRUE(source);
  const Drained d = drain(**source);
  EXPECT_EQ(d.scans, 80U);
  EXPECT_LT(d.last.s(), 1008.5) << "the jump is closed";
  EXPECT_TRUE(d.ordered);
  EXPECT_EQ((*source)->report().gaps.jumps, 2U) << "seen once by each sensor";
  EXPECT_TRUE(has((*source)->report().findings, "D04"));
}

TEST(RecordingEvents, takes_record_time_for_an_imu_on_a_boot_clock) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1.7e9, 5.0,
                        [](double t, bool imu) { return imu ? t - 1.7e9 + 7403.0 : t; });
  const auto source = open_recording_events({recording.save(folder)}, {});
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->report().imu_stamp, "record");
  EXPECT_EQ((*source)->report().lidar_stamp, "header");
  const Drained d = drain(**source);
  EXPECT_EQ(d.scans, 50U);
  EXPECT_EQ(d.imu, 500U);
  EXPECT_GT(d.first.s(), 1.69e9);
}

TEST(RecordingEvents, takes_record_time_for_headers_of_zero) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 5.0, [](double t, bool imu) { return imu ? t : 0.0; });
  const auto source = open_recording_events({recording.save(folder)}, {});
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->report().lidar_stamp, "record");
  const Drained d = drain(**source);
  EXPECT_EQ(d.scans, 50U);
  EXPECT_NEAR(d.last_scan.s(), 1004.995, 0.01);
}

TEST(RecordingEvents, scales_an_imu_in_g) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.accel = 1.0;
  recording.add_seconds(1000.0, 4.0, as_is);
  const auto source = open_recording_events({recording.save(folder)}, {});
  ASSERT_TRUE(source);
  EXPECT_NEAR((*source)->report().accel_scale, 9.80665, 1e-9);
  EXPECT_TRUE(has((*source)->report().findings, "D08"));
}

TEST(RecordingEvents, reads_two_recordings_in_a_row_and_counts_the_pause) {
  const io::TestFolder folder;
  FakeRecording first, second;
  first.add_seconds(1000.0, 4.0, as_is);
  second.add_seconds(1010.0, 4.0, as_is);
  const auto source =
      open_recording_events({first.save(folder, "a.mcap"), second.save(folder, "b.mcap")}, {});
  ASSERT_TRUE(source);
  const Drained d = drain(**source);
  EXPECT_EQ(d.scans, 80U);
  EXPECT_NEAR((*source)->report().gaps.missing_s, 6.0, 0.2);
  EXPECT_EQ((*source)->report().gaps.jumps, 0U);
}

TEST(RecordingEvents, reads_a_truncated_file_to_its_end_and_reports_damage) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 6.0, as_is);
  std::string path = recording.save(folder);
  const std::string whole = folder.read("v1.mcap");
  path = folder.write("cut.mcap", std::string_view(whole).substr(0, whole.size() * 2 / 3));
  const auto source = open_recording_events({path}, {});
  ASSERT_TRUE(source) << source.error().message();
  const Drained d = drain(**source);
  EXPECT_GT(d.scans, 20U);
  EXPECT_LT(d.scans, 60U);
  EXPECT_TRUE((*source)->report().gaps.damaged);
  EXPECT_TRUE(d.ordered);
}

TEST(RecordingEvents, refuses_extrinsics_that_turn_the_lidar_upside_down) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 4.0, as_is);
  InputOptions options;
  options.T_body_lidar.emplace().R = geometry::rotation_from_rpy(3.14159265, 0.0, 0.0);
  const auto source = open_recording_events({recording.save(folder)}, options);
  ASSERT_FALSE(source);
  EXPECT_NE(source.error().message().find("T_body_lidar does not fit the data"), std::string::npos);
}

}  // namespace
}  // namespace rali::drive
