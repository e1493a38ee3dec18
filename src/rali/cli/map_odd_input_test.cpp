// `rali map` on faulty but plausible recordings: each ends in a defined way.

#include <filesystem>
#include <functional>

#include <gtest/gtest.h>

#include "rali/cli/app.hpp"
#include "rali/cli/run_for_test.hpp"
#include "rali/drive/hall_recording_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

using drive::test::HallRecording;

/// A drive through the hall, with configurable faults of sensors and clocks.
struct OddRecording {
  double duration_s = 2.5;
  double imu_hz = 200.0;  ///< 0: no IMU
  double imu_delay_s = 0.0;
  int rings = 16, columns = 300;  ///< 0 columns: no LiDAR
  bool zero_stamps = false, twice = false;

  [[nodiscard]] sensor::LidarScan scan(int index) const {
    sensor::LidarScan scan;
    Rng noise(static_cast<std::uint64_t>(index), "noise");
    for (int column = 0; column < columns; ++column) {
      const double dt = 0.1 * column / columns;
      const geometry::SE3 T = HallRecording::pose(0.1 * index + dt);
      const double azimuth = std::numbers::pi - 2.0 * std::numbers::pi * column / columns;
      for (int ring = 0; ring < rings; ++ring) {
        const double elevation = rings > 1 ? -0.26 + 0.52 * ring / (rings - 1) : 0.001;
        const geometry::Vec3 d{std::cos(elevation) * std::cos(azimuth),
                               std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
        const double range = HallRecording::distance(T.p, T.R * d) + 0.01 * noise.normal();
        const geometry::Vec3f p = (range * d).cast<float>();
        scan.push_back(p.x(), p.y(), p.z(), 10.0F, static_cast<float>(dt),
                       static_cast<std::uint16_t>(ring));
      }
    }
    scan.t_start = stamp(0.1 * index);
    scan.t_end = scan.t_start + Duration::from_s(0.1);
    scan.has_point_times = scan.has_rings = true;
    scan.rings = static_cast<std::uint16_t>(rings);
    return scan;
  }

  [[nodiscard]] Time stamp(double t_s) const {
    if (zero_stamps) return Time{};
    return Time::from_s(HallRecording::kStart_s) + Duration::from_s(t_s);
  }

  [[nodiscard]] std::string write(const io::TestFolder& folder) const {
    io::MemorySink sink;
    io::BagWriter bag(sink, io::BagWriter::Options{});
    const auto clouds = drive::test::connect(bag, "/points", "sensor_msgs/PointCloud2");
    const auto inertial = drive::test::connect(bag, "/imu/data", "sensor_msgs/Imu");
    const HallRecording hall;
    Rng noise(1, "imu");
    bool whole = true;
    const auto put = [&](std::uint32_t topic, double t_s, const wire::Bytes& bytes) {
      const Time now = Time::from_s(HallRecording::kStart_s) + Duration::from_s(t_s + 0.001);
      for (int i = 0; i < (twice ? 2 : 1); ++i) {
        whole = whole && bag.write(topic, now, bytes).has_value();
      }
    };
    const int imu_every = imu_hz > 0.0 ? static_cast<int>(200.0 / imu_hz) : 0;
    for (int tick = 0; tick < static_cast<int>(duration_s * 200.0); ++tick) {
      const double t_s = tick / 200.0;
      if (imu_every > 0 && tick % imu_every == 0) {
        wire::ImuMessage message = hall.imu(t_s, noise);
        message.sample.t = stamp(t_s + imu_delay_s);
        put(inertial, t_s + imu_delay_s, wire::encode(message, wire::Encoding::kRos1));
      }
      if (columns == 0 || tick % 20 != 0 || tick == 0) continue;
      const wire::PackedCloud packed =
          wire::pack_cloud(scan(tick / 20 - 1), "lidar", wire::CloudStyle::kVelodyne);
      put(clouds, t_s, wire::encode(packed.view, wire::Encoding::kRos1));
    }
    EXPECT_TRUE(whole && bag.close());
    const auto& bytes = sink.bytes();
    return folder.write("v1.bag", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
};

struct Odd {
  std::string name;
  OddRecording recording;
  int code;
  std::string reported;
};

std::vector<Odd> odd_recordings() {
  constexpr double kDriven_s = 9.0;  // it stands at first, which the inertial data alone show
  std::vector<Odd> all;
  const auto add = [&](const std::string& name, int code, const std::string& reported,
                       const std::function<void(OddRecording&)>& change) {
    all.push_back({name, {}, code, reported});
    change(all.back().recording);
  };
  add("IMU only", 2, "no point cloud", [](OddRecording& r) { r.columns = 0; });
  add("LiDAR only", 0, "", [](OddRecording& r) { r.imu_hz = 0.0; });
  add("IMU at 1 Hz", 3, "too slow to be integrated: mapped with LiDAR alone",
      [](OddRecording& r) { r.imu_hz = 1.0; });
  add("IMU at 8 Hz", 3, "too slow to be integrated: mapped with LiDAR alone",
      [](OddRecording& r) { r.imu_hz = 8.0; });
  add("IMU after the LiDAR", 3, "inertial data lie wholly after the scans",
      [](OddRecording& r) { r.imu_delay_s = 30.0; });
  add("IMU before the LiDAR", 3, "inertial data lie wholly before the scans",
      [](OddRecording& r) { r.imu_delay_s = -30.0; });
  add("all twice", 0, "", [](OddRecording& r) { r.twice = true; });
  add("stamps of 0", 0, "the record time is used", [](OddRecording& r) { r.zero_stamps = true; });
  add("three points", 3, "",
      [](OddRecording& r) { r.rings = 1, r.columns = 3, r.duration_s = kDriven_s; });
  add("one ring", 3, "degenerate: v1 100 %",
      [](OddRecording& r) { r.rings = 1, r.duration_s = kDriven_s; });
  add("300 rings", 0, "", [](OddRecording& r) { r.rings = 300, r.columns = 60; });
  return all;
}

TEST(MapOddInput, gives_the_expected_exit_code_and_message) {
  for (const Odd& odd : odd_recordings()) {
    const io::TestFolder folder;
    const std::string input = odd.recording.write(folder);
    const Outcome run =
        run_rali({"map", input, "-o", folder.path("out"), "--no-mcap", "--threads", "1"});
    const std::string reported = run.out + run.err;
    EXPECT_EQ(run.code, odd.code) << odd.name << '\n' << reported;
    EXPECT_NE(reported.find(odd.reported), std::string::npos) << odd.name << '\n' << reported;
  }
}

}  // namespace
}  // namespace rali::cli
