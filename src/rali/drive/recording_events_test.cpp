#include "rali/drive/recording_events.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/io/containers/mcap_writer.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/wire/cloud_pack.hpp"
#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::drive {
namespace {

constexpr auto kCdr = wire::Encoding::kCdr;

/// An MCAP of a vehicle that stands on a floor: 10 Hz sweeps, 100 Hz inertial data.
class FakeRecording {
 public:
  FakeRecording() {
    cloud_ = channel("/points", "sensor_msgs/msg/PointCloud2");
    imu_ = channel("/imu", "sensor_msgs/msg/Imu");
  }

  void add_imu(double header_s, double record_s) {
    wire::ImuMessage message;
    message.frame_id = "imu";
    message.sample.t = Time::from_s(header_s);
    message.sample.accel_mps2 = {0.0, 0.0, accel};
    message.sample.gyro_radps = {0.001, 0.0, 0.0};
    write(imu_, record_s, wire::encode(message, kCdr));
  }

  /// A sweep that ends at header_s + 0.09; the header names its start.
  void add_cloud(double header_s, double record_s) {
    sensor::LidarScan scan;
    scan.t_begin = Time::from_s(header_s);
    scan.t_end = Time::from_s(header_s + 0.09);
    scan.has_point_times = scan.has_rings = true;
    scan.rings = 16;
    for (int i = 0; i < 300; ++i) {
      for (int ring = 0; ring < 12; ++ring) {
        const double a = i * 2.0 * 3.14159265 / 300.0, r = 3.0 + 0.3 * ring;
        scan.push_back(static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)),
                       -1.0F, 1.0F, static_cast<float>(i) * 3e-4F,
                       static_cast<std::uint16_t>(ring));
      }
    }
    const wire::PackedCloud cloud = wire::pack_cloud(scan, "lidar", wire::CloudStyle::kVelodyne);
    write(cloud_, record_s, wire::encode(cloud.view, kCdr));
  }

  /// v1 to v2 on /ranges; a stamp of 0 leaves it to the recorder.
  void add_range(double header_s, double record_s) {
    if (!ranges_) ranges_ = channel("/ranges", "rali_msgs/msg/Range");
    wire::RangeMessage message;
    message.stamp = Time::from_s(header_s);
    message.from = "v1";
    message.to = "v2";
    message.range_m = 7.5;
    write(*ranges_, record_s, wire::encode(message, kCdr));
  }

  /// Stamps from `t0` on; `warp` may change the headers of either sensor.
  template <class Warp>
  void add_seconds(double t0, double seconds, Warp warp) {
    const int steps = static_cast<int>(std::lround(seconds * 100.0));
    for (int i = 0; i < steps; ++i) {
      const double t = t0 + 0.01 * i;
      add_imu(warp(t, true), t + 0.002);
      if (i % 10 == 9) add_cloud(warp(t - 0.09, false), t + 0.005);
    }
  }

  std::string save(const io::TestFolder& folder, const std::string& name = "v1.mcap") {
    EXPECT_TRUE(writer_.close());
    const auto& b = sink_.bytes();
    return folder.write(name, {reinterpret_cast<const char*>(b.data()), b.size()});
  }

  double accel = 9.81;

 private:
  std::uint16_t channel(const std::string& topic, const std::string& type) {
    const auto schema = writer_.add_schema(type, "ros2msg", wire::message_definition(type, kCdr));
    return *writer_.add_channel(*schema, topic, "cdr");
  }

  void write(std::uint16_t channel, double record_s, const wire::Bytes& bytes) {
    const Time t = Time::from_s(record_s);
    EXPECT_TRUE(writer_.write(channel, t, t, bytes));
  }

  io::MemorySink sink_;
  io::McapWriter writer_{sink_, {}};
  std::uint16_t cloud_ = 0, imu_ = 0;
  std::optional<std::uint16_t> ranges_;
};

double as_is(double t, bool) { return t; }

struct Drained {
  std::size_t sweeps = 0, imu = 0;
  std::vector<Time> ranges;
  bool ordered = true;
  Time first, last;
  Time last_sweep, first_sweep;
};

Drained drain(ReportedSource& source) {
  Drained d;
  bool any = false;
  while (true) {
    const auto event = source.next();
    EXPECT_TRUE(event);
    if (!event || !*event) return d;
    Time t;
    if (const auto* imu = std::get_if<sensor::ImuSample>(&**event)) {
      t = imu->t;
      ++d.imu;
    } else if (const auto* range = std::get_if<sensor::RangeSample>(&**event)) {
      t = range->t;
      d.ranges.push_back(t);
    } else {
      t = std::get<std::shared_ptr<const sensor::LidarScan>>(**event)->t_end;
      if (d.sweeps++ == 0) d.first_sweep = t;
      d.last_sweep = t;
    }
    if (!any) d.first = t;
    d.ordered &= !any || t >= d.last;
    d.last = t;
    any = true;
  }
}

bool has(const FindingList& findings, const std::string& id) {
  for (const Finding& f : findings) {
    if (f.id == id && f.severity != Severity::kInfo) return true;
  }
  return false;
}

InputOptions with_ranges() {
  auto ranges = std::make_shared<RangeOptions>();
  ranges->names = {{"v1", {VehicleId{0}, 0}}, {"v2", {VehicleId{1}, 0}}};
  ranges->antennas = {1, 1};
  ranges->topics = {{"/ranges", {}}};
  InputOptions options;
  options.ranges = ranges;
  return options;
}

TEST(RecordingEvents, ranges_of_a_named_topic_come_in_between_and_change_nothing_else) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 4.0, as_is);
  recording.add_range(1003.905, 1003.92);  // 65 ms late, and beside it all sensor data
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
  EXPECT_EQ(p.sweeps, d.sweeps);
  EXPECT_EQ(p.imu, d.imu);
  EXPECT_EQ((*source)->report().gaps.late, (*plain)->report().gaps.late);
}

TEST(RecordingEvents, ranges_stamped_by_the_recorder_are_moved_to_the_clock_of_the_sensors) {
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

TEST(RecordingEvents, hands_out_everything_once_and_in_order) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 6.0, as_is);
  const auto source = open_recording_events({recording.save(folder)}, {});
  ASSERT_TRUE(source) << source.error().message();
  const Drained d = drain(**source);
  EXPECT_EQ(d.sweeps, 60U);
  EXPECT_EQ(d.imu, 600U);
  EXPECT_TRUE(d.ordered);
  const InputReport& report = (*source)->report();
  EXPECT_EQ(report.lidar_topic, "/points");
  EXPECT_EQ(report.imu_topic, "/imu");
  EXPECT_TRUE(report.has_imu);
  EXPECT_EQ(report.gaps.late + report.gaps.jumps + report.gaps.repeated, 0U);
  EXPECT_FALSE(report.gaps.damaged);
  EXPECT_NEAR(d.last_sweep.s(), 1005.99, 2e-3);
}

TEST(RecordingEvents, keeps_start_duration_and_the_time_offset) {
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
  EXPECT_NEAR(static_cast<double>(d.sweeps), 10.0, 1.0);
  EXPECT_NEAR(std::fmod(d.first_sweep.s() - 1000.0, 0.1), 0.015, 2e-3) << "0.09 + 0.025 s";
}

TEST(RecordingEvents, closes_a_clock_jump_of_both_sensors_alike) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 8.0, [](double t, bool) { return t < 1005.0 ? t : t + 500.0; });
  const auto source = open_recording_events({recording.save(folder)}, {});
  ASSERT_TRUE(source);
  const Drained d = drain(**source);
  EXPECT_EQ(d.sweeps, 80U);
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
  EXPECT_EQ(d.sweeps, 50U);
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
  EXPECT_EQ(d.sweeps, 50U);
  EXPECT_NEAR(d.last_sweep.s(), 1004.995, 0.01);
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
  EXPECT_EQ(d.sweeps, 80U);
  EXPECT_NEAR((*source)->report().gaps.missing_s, 6.0, 0.2);
  EXPECT_EQ((*source)->report().gaps.jumps, 0U);
}

TEST(RecordingEvents, goes_on_to_the_cut_and_says_that_data_is_missing) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 6.0, as_is);
  std::string path = recording.save(folder);
  const std::string whole = folder.read("v1.mcap");
  path = folder.write("cut.mcap", std::string_view(whole).substr(0, whole.size() * 2 / 3));
  const auto source = open_recording_events({path}, {});
  ASSERT_TRUE(source) << source.error().message();
  const Drained d = drain(**source);
  EXPECT_GT(d.sweeps, 20U);
  EXPECT_LT(d.sweeps, 60U);
  EXPECT_TRUE((*source)->report().gaps.damaged);
  EXPECT_TRUE(d.ordered);
}

TEST(RecordingEvents, refuses_a_lidar_that_is_given_upside_down) {
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
