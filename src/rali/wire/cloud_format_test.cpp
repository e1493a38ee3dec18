#include "rali/wire/cloud_format.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "rali/wire/cloud_pack.hpp"
#include "rali/wire/decode.hpp"
#include "rali/wire/encode.hpp"
#include "rali/wire/internal/test_clouds.hpp"

// One test per row of users.md section 3 and per pitfall there: first the decision, then the
// points.
namespace rali::wire {
namespace {

using internal::expect_third;
using internal::has_finding;
using internal::kStart;
using internal::three;
using internal::views;
using internal::vlp16_scan;
using sensor::LidarScan;

TEST(CloudFormat, velodyne_times_are_seconds_after_the_header) {
  for (const bool big_endian : {false, true}) {
    for (const CloudStyle style : {CloudStyle::kVelodyne, CloudStyle::kVelodynePcl}) {
      const auto clouds = three(style, HeaderStamp::kStart, big_endian);
      const auto format = decide_cloud_format(views(clouds), {});
      ASSERT_TRUE(format.has_value()) << format.error().message();
      EXPECT_EQ(format->point_time, PointTime::kRelativeS);
      EXPECT_EQ(format->header_stamp, HeaderStamp::kStart);
      EXPECT_EQ(format->rings, 16);
      EXPECT_EQ(format->ring_from, RingFrom::kField);
      EXPECT_EQ(format->model, "vlp16");
      EXPECT_EQ(format->summary,
                "time: field 'time' float32 s after the header (span 0.0999 s); stamp = start of "
                "scan; ring: field 'ring' 0..15; model vlp16 (guessed from the elevations)");
      EXPECT_TRUE(format->findings.empty());
      expect_third(clouds[2].view, *format, {}, 1e-6);
    }
  }
}

TEST(CloudFormat, negative_times_mean_the_header_stamps_the_end_of_the_scan) {
  const auto clouds = three(CloudStyle::kVelodyne, HeaderStamp::kEnd);
  const auto format = decide_cloud_format(views(clouds), {});
  ASSERT_TRUE(format.has_value());
  EXPECT_EQ(format->header_stamp, HeaderStamp::kEnd);
  EXPECT_TRUE(has_finding(*format, "D03"));
  expect_third(clouds[2].view, *format, {}, 1e-6);
}

TEST(CloudFormat, ouster_t_is_nanoseconds_after_the_header) {
  for (const bool big_endian : {false, true}) {
    const auto clouds = three(CloudStyle::kOuster, HeaderStamp::kStart, big_endian);
    const auto format = decide_cloud_format(views(clouds), {});
    ASSERT_TRUE(format.has_value());
    EXPECT_EQ(format->point_time, PointTime::kRelativeNs);
    EXPECT_EQ(format->time_scale_s, 1e-9);
    expect_third(clouds[2].view, *format, {}, 1e-6);
  }
}

TEST(CloudFormat, robosense_timestamps_are_absolute_seconds) {
  for (const HeaderStamp stamp : {HeaderStamp::kStart, HeaderStamp::kEnd}) {
    for (const bool big_endian : {false, true}) {
      const auto clouds = three(CloudStyle::kRoboSense, stamp, big_endian);
      const auto format = decide_cloud_format(views(clouds), {});
      ASSERT_TRUE(format.has_value());
      EXPECT_EQ(format->point_time, PointTime::kAbsoluteS);
      EXPECT_EQ(format->header_stamp, stamp);
      EXPECT_FALSE(format->anchor_to_header);
      expect_third(clouds[2].view, *format, {}, 1e-6);  // float64 of 1.7e9 s: steps of 238 ns
    }
  }
}

TEST(CloudFormat, livox_timestamps_are_absolute_nanoseconds_in_a_double) {
  const auto clouds = three(CloudStyle::kLivox);
  const auto format = decide_cloud_format(views(clouds), {});
  ASSERT_TRUE(format.has_value());
  EXPECT_EQ(format->point_time, PointTime::kAbsoluteNs);
  EXPECT_EQ(format->header_stamp, HeaderStamp::kStart);
  LidarScan got;
  ASSERT_TRUE(decode_cloud(clouds[2].view, *format, {}, got).has_value());
  // steps of 256 ns
  EXPECT_NEAR(seconds_between(clouds[2].view.stamp, got.t_start), 0.0, 300e-9);
  EXPECT_NEAR(static_cast<double>(got.dt_s.back()), 0.1 * 899.0 / 900.0, 1e-6);
}

TEST(CloudFormat, livox_custom_messages_of_ros1_and_ros2_give_the_same_scan) {
  LivoxCustom custom;
  custom.stamp = kStart;
  custom.timebase_ns = static_cast<std::uint64_t>(kStart.ns);
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const float angle = 0.5F * std::sin(0.01F * static_cast<float>(i));
    custom.points.push_back({i * 50'000, 10.0F * std::cos(angle), 10.0F * std::sin(angle),
                             0.001F * static_cast<float>(i), 50, 16,
                             static_cast<std::uint8_t>(i % 4)});
  }
  for (const Encoding encoding : {Encoding::kRos1, Encoding::kCdr}) {
    for (const bool big_endian : {false, true}) {
      const Bytes message = encode(custom, encoding, big_endian);
      const auto cloud = decode_cloud_message(MessageKind::kLivoxCustom, message, encoding);
      ASSERT_TRUE(cloud.has_value());
      const auto format = decide_cloud_format(std::span(&*cloud, 1), {});
      ASSERT_TRUE(format.has_value()) << format.error().message();
      EXPECT_EQ(format->point_time, PointTime::kRelativeNs);
      EXPECT_EQ(format->model, "mid360");
      LidarScan scan;
      ASSERT_TRUE(decode_cloud(*cloud, *format, {}, scan).has_value());
      ASSERT_EQ(scan.size(), 2000U);
      EXPECT_EQ(scan.t_start.ns, kStart.ns);
      EXPECT_FLOAT_EQ(scan.dt_s[1999], 0.09995F);
      EXPECT_EQ(scan.ring[7], 3);
      EXPECT_EQ(scan.rings, 4);
      EXPECT_EQ(scan.intensity[0], 50.0F);
    }
  }
}

TEST(CloudFormat, clouds_without_times_get_them_from_the_azimuth_of_a_known_model) {
  const auto clouds = three(CloudStyle::kXyzi);
  const auto format = decide_cloud_format(views(clouds), {});
  ASSERT_TRUE(format.has_value());
  EXPECT_EQ(format->point_time, PointTime::kAzimuth);
  EXPECT_TRUE(format->azimuth_clockwise);
  EXPECT_EQ(format->ring_from, RingFrom::kElevation);
  EXPECT_EQ(format->model, "vlp16");
  EXPECT_TRUE(has_finding(*format, "D02"));
  expect_third(clouds[2].view, *format, {}, 1e-4);
}

TEST(CloudFormat, clouds_farther_apart_than_one_revolution_get_no_times) {
  auto clouds = three(CloudStyle::kXyzi);
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    clouds[k].view.stamp = kStart + Duration::from_s(0.5 * static_cast<double>(k));
  }
  const auto format = decide_cloud_format(views(clouds), {});
  ASSERT_TRUE(format.has_value());
  EXPECT_EQ(format->point_time, PointTime::kNone) << format->summary;
}

TEST(CloudFormat, kitti_clouds_without_rings_are_timed_clockwise_from_the_rear) {
  // KITTI .bin: ring by ring, each from azimuth 0 upward, x y z intensity.
  const LidarScan scan = vlp16_scan(kStart);
  LidarScan sorted;
  for (std::uint16_t ring = 0; ring < 16; ++ring) {
    for (std::size_t i = scan.size(); i-- > 0;) {
      if (scan.ring[i] != ring) continue;
      sorted.push_back(scan.x_m[i], scan.y_m[i], scan.z_m[i], 0.0F, scan.dt_s[i], ring);
    }
  }
  const PackedCloud cloud = pack_cloud(sorted, "", CloudStyle::kXyzi);
  const auto format = decide_cloud_format(std::span(&cloud.view, 1), {});
  ASSERT_TRUE(format.has_value());
  ASSERT_EQ(format->point_time, PointTime::kAzimuth);
  LidarScan got;
  ASSERT_TRUE(decode_cloud(cloud.view, *format, {}, got).has_value());
  for (std::size_t i = 0; i < got.size(); i += 31) {
    const auto azimuth = static_cast<double>(std::atan2(got.y_m[i], got.x_m[i]));
    const double want_s = 0.1 * 0.5 * (1.0 - azimuth / std::numbers::pi);
    if (want_s > 0.0999) continue;  // the rear itself may be the first or the last
    EXPECT_NEAR(static_cast<double>(got.dt_s[i]), want_s, 1e-6);
    EXPECT_EQ(got.ring[i], sorted.ring[i]);
  }
}

TEST(CloudFormat, all_zero_times_fall_back_to_azimuth_with_a_finding) {
  auto clouds = three(CloudStyle::kRoboSense);
  for (PackedCloud& cloud : clouds) {
    for (std::size_t i = 0; i < cloud.view.width; ++i) {
      std::fill_n(cloud.data.begin() + static_cast<std::ptrdiff_t>(i * 26 + 18), 8, std::byte{0});
    }
  }
  const auto format = decide_cloud_format(views(clouds), {});
  ASSERT_TRUE(format.has_value());
  EXPECT_EQ(format->point_time, PointTime::kAzimuth);
  EXPECT_EQ(format->findings[0].id, "D02");
  EXPECT_EQ(format->findings[0].text, "field 'timestamp' is 0 in every point");
}

TEST(CloudFormat, an_unknown_sensor_without_times_is_not_deskewed) {
  LidarScan scan;
  for (int i = 0; i < 5000; ++i) {
    const float a = 0.37F * static_cast<float>(i);
    scan.push_back(5.0F * std::cos(a), 5.0F * std::sin(a), std::sin(0.731F * static_cast<float>(i)),
                   0.0F, 0.0F, 0);
  }
  const PackedCloud cloud = pack_cloud(scan, "", CloudStyle::kXyzi);
  const auto format = decide_cloud_format(std::span(&cloud.view, 1), {});
  ASSERT_TRUE(format.has_value());
  EXPECT_EQ(format->point_time, PointTime::kNone);
  EXPECT_EQ(format->ring_from, RingFrom::kNone);
  EXPECT_TRUE(has_finding(*format, "D02"));
  EXPECT_EQ(format->summary, "time: none, deskewing off; ring: none; model not known");
  LidarScan got;
  ASSERT_TRUE(decode_cloud(cloud.view, *format, {}, got).has_value());
  EXPECT_FALSE(got.has_point_times);
  EXPECT_EQ(got.t_start, got.t_end);
}

/// Rewrites field `time` (float32 @18 of the Velodyne layout) as another type and unit.
template <class T>
std::vector<PackedCloud> with_times(FieldType type, std::string name, double unit_per_s,
                                    double offset_s = 0.0) {
  auto clouds = three(CloudStyle::kVelodynePcl);
  for (PackedCloud& cloud : clouds) {
    cloud.view.fields.back() = {name, 24, type, 1};
    for (std::size_t i = 0; i < cloud.view.width; ++i) {
      std::byte* at = cloud.data.data() + i * 32 + 24;
      const double t_s = static_cast<double>(load<float>(at, false)) + offset_s;
      const T value = static_cast<T>(t_s * unit_per_s);
      std::memcpy(at, &value, sizeof(T));
    }
  }
  return clouds;
}

TEST(CloudFormat, the_time_unit_is_detected_by_value_for_any_field_name) {
  struct Row {
    std::vector<PackedCloud> clouds;
    PointTime want;
  };

  const Row rows[] = {
      {with_times<float>(FieldType::kFloat32, "time", 1.0), PointTime::kRelativeS},
      {with_times<float>(FieldType::kFloat32, "t", 1e3), PointTime::kRelativeMs},
      {with_times<float>(FieldType::kFloat32, "timestamp", 1e6), PointTime::kRelativeUs},
      {with_times<float>(FieldType::kFloat32, "timeStamp", 1e9), PointTime::kRelativeNs},
      {with_times<double>(FieldType::kFloat64, "time_stamp", 1e3), PointTime::kRelativeMs},
      {with_times<std::uint32_t>(FieldType::kUint32, "offset_time", 1e9), PointTime::kRelativeNs},
      {with_times<std::uint32_t>(FieldType::kUint32, "t", 1e6), PointTime::kRelativeUs},
      {with_times<std::int32_t>(FieldType::kInt32, "t", 1e9, -0.0999), PointTime::kRelativeNs},
      {with_times<std::uint16_t>(FieldType::kUint16, "t", 1e3), PointTime::kRelativeMs},
  };
  for (const Row& row : rows) {
    const auto format = decide_cloud_format(views(row.clouds), {});
    ASSERT_TRUE(format.has_value());
    EXPECT_EQ(format->point_time, row.want) << format->summary;
    EXPECT_NEAR(format->span_s, 0.0999, 0.001) << format->summary;
  }
}

TEST(CloudFormat, point_times_on_another_clock_are_aligned_to_the_header) {
  // a sensor that counts from its start, 7403 s ago; IMU and header run on the computer's clock
  auto clouds = three(CloudStyle::kRoboSense);
  for (PackedCloud& cloud : clouds) {
    for (std::size_t i = 0; i < cloud.view.width; ++i) {
      std::byte* at = cloud.data.data() + i * 26 + 18;
      const double t_s = load<double>(at, false) - kStart.s() + 7403.0;
      std::memcpy(at, &t_s, sizeof(t_s));
    }
  }
  const auto format = decide_cloud_format(views(clouds), {});
  ASSERT_TRUE(format.has_value());
  EXPECT_TRUE(format->anchor_to_header);
  EXPECT_TRUE(has_finding(*format, "D03"));
  expect_third(clouds[2].view, *format, {}, 1e-6);
  CloudFormatOptions end;
  end.header_stamp = HeaderStamp::kEnd;
  const auto at_end = decide_cloud_format(views(clouds), end);
  LidarScan got;
  ASSERT_TRUE(decode_cloud(clouds[2].view, *at_end, end, got).has_value());
  EXPECT_NEAR(seconds_between(clouds[2].view.stamp, got.t_end), 0.0, 1e-6);
}

TEST(CloudFormat, zero_header_stamps_keep_the_absolute_point_times) {
  auto clouds = three(CloudStyle::kRoboSense);
  for (PackedCloud& cloud : clouds) cloud.view.stamp = Time{};
  const auto format = decide_cloud_format(views(clouds), {});
  ASSERT_TRUE(format.has_value());
  EXPECT_FALSE(format->anchor_to_header);
  EXPECT_TRUE(has_finding(*format, "D03"));
  expect_third(clouds[2].view, *format, {}, 1e-6);
}

TEST(CloudFormat, header_stamp_option_end_shifts_the_scan_start) {
  const auto clouds = three(CloudStyle::kVelodyne);
  CloudFormatOptions options;
  options.header_stamp = HeaderStamp::kEnd;
  const auto format = decide_cloud_format(views(clouds), options);
  ASSERT_TRUE(format.has_value());
  LidarScan got;
  ASSERT_TRUE(decode_cloud(clouds[1].view, *format, options, got).has_value());
  EXPECT_NEAR(seconds_between(clouds[1].view.stamp, got.t_end), 0.0, 1e-6);
  EXPECT_NEAR(seconds_between(clouds[1].view.stamp, got.t_start), -0.0999, 1e-4);
}

TEST(CloudFormat, implausible_scan_durations_fall_back_to_azimuth_with_a_finding) {
  const auto clouds = with_times<float>(FieldType::kFloat32, "time", 40.0);  // 4 s a scan
  const auto format = decide_cloud_format(views(clouds), {});
  ASSERT_TRUE(format.has_value());
  EXPECT_EQ(format->point_time, PointTime::kAzimuth);
  EXPECT_NE(format->findings[0].text.find("spans 3.99"), std::string::npos)
      << format->findings[0].text;
}

TEST(CloudFormat, a_configured_unit_giving_100_s_scans_is_refused) {
  const auto seconds = with_times<double>(FieldType::kFloat64, "time", 1e3);  // 100 s a scan
  const auto endless = with_times<double>(FieldType::kFloat64, "time", 1e300);
  CloudFormatOptions options;
  for (const PointTime set : {PointTime::kRelativeS, PointTime::kAbsoluteS}) {
    options.point_time = set;
    const auto format = decide_cloud_format(views(seconds), options);
    ASSERT_FALSE(format.has_value());
    EXPECT_EQ(format.error().where, "lidar.point_time");
    EXPECT_NE(format.error().what.find("spans 99.89 s in a scan if it counts s"), std::string::npos)
        << format.error().what;
    EXPECT_FALSE(decide_cloud_format(views(endless), options).has_value());
  }
  options.point_time = PointTime::kRelativeMs;  // 0.1 s
  EXPECT_TRUE(decide_cloud_format(views(seconds), options).has_value());
}

TEST(CloudFormat, a_scan_duration_inconsistent_with_the_rate_is_reported) {
  auto clouds = three(CloudStyle::kVelodyne);
  for (int i = 0; i < 3; ++i) {
    clouds[static_cast<std::size_t>(i)].view.stamp = kStart + Duration::from_s(0.05 * i);
  }
  const auto format = decide_cloud_format(views(clouds), {});
  ASSERT_TRUE(format.has_value());
  EXPECT_EQ(format->point_time, PointTime::kRelativeS);
  EXPECT_TRUE(has_finding(*format, "D02"));
}

TEST(CloudFormat, configured_options_override_detection) {
  const auto clouds = three(CloudStyle::kVelodyne);
  CloudFormatOptions options;
  options.point_time = PointTime::kNone;
  EXPECT_EQ(decide_cloud_format(views(clouds), options)->point_time, PointTime::kNone);
  options.point_time = PointTime::kAzimuth;
  EXPECT_EQ(decide_cloud_format(views(clouds), options)->point_time, PointTime::kAzimuth);
  options.point_time = PointTime::kRelativeS;
  EXPECT_EQ(decide_cloud_format(views(clouds), options)->point_time, PointTime::kRelativeS);
  const auto plain = three(CloudStyle::kXyzi);
  const auto missing = decide_cloud_format(views(plain), options);
  ASSERT_FALSE(missing.has_value());
  EXPECT_EQ(missing.error().where, "lidar.point_time");
  options = {};
  options.model = "vlp17";
  EXPECT_EQ(decide_cloud_format(views(plain), options).error().code, ErrorCode::kUsage);
  options = {};
  options.deskewed = true;
  const auto deskewed = decide_cloud_format(views(clouds), options);
  LidarScan got;
  ASSERT_TRUE(decode_cloud(clouds[0].view, *deskewed, options, got).has_value());
  EXPECT_TRUE(got.deskewed);
  EXPECT_FALSE(got.has_point_times);
  EXPECT_EQ(got.t_end, clouds[0].view.stamp);
}

TEST(CloudFormat, clouds_without_xyz_and_missing_clouds_have_different_error_codes) {
  auto clouds = three(CloudStyle::kXyzi);
  EXPECT_EQ(decide_cloud_format({}, {}).error().code, ErrorCode::kNoAnswer);
  clouds[0].view.fields[2].name = "zz";
  EXPECT_EQ(decide_cloud_format(views(clouds), {}).error().code, ErrorCode::kInput);
  clouds = three(CloudStyle::kXyzi);
  clouds[0].view.width = 0;  // skipped
  EXPECT_TRUE(decide_cloud_format(views(clouds), {}).has_value());
}

/// The same room in another unit.
std::vector<PackedCloud> scaled(float factor) {
  std::vector<PackedCloud> clouds;
  for (int i = 0; i < 3; ++i) {
    LidarScan scan = vlp16_scan(kStart + Duration::from_s(0.1 * i));
    for (std::vector<float>* v : {&scan.x_m, &scan.y_m, &scan.z_m}) {
      for (float& value : *v) value *= factor;
    }
    clouds.push_back(pack_cloud(scan, "lidar", CloudStyle::kVelodyne));
  }
  return clouds;
}

TEST(CloudFormat, coordinates_in_millimetres_or_centimetres_are_refused) {
  for (const auto& [factor, unit] : std::vector<std::pair<float, std::string>>{
           {1000.0F, "millimetres"}, {100.0F, "centimetres"}}) {
    const auto clouds = scaled(factor);
    const auto format = decide_cloud_format(views(clouds), {});
    ASSERT_FALSE(format) << "nothing of it would be mapped";
    EXPECT_EQ(format.error().code, ErrorCode::kInput);
    EXPECT_NE(format.error().what.find("the unit is " + unit), std::string::npos)
        << format.error().message();
  }
  EXPECT_TRUE(decide_cloud_format(views(scaled(3.0F)), {})) << "a large hall is no other unit";
  CloudFormatOptions far;
  far.range_m = {0.4, 100'000.0};
  EXPECT_TRUE(decide_cloud_format(views(scaled(1000.0F)), far)) << "as the user says";
}

}  // namespace
}  // namespace rali::wire
