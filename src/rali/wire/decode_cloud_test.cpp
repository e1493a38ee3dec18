#include <array>
#include <limits>

#include <gtest/gtest.h>

#include "rali/wire/cloud_format.hpp"
#include "rali/wire/cloud_pack.hpp"
#include "rali/wire/internal/test_scan.hpp"

namespace rali::wire {
namespace {

using internal::vlp16_scan;
using sensor::LidarScan;

const Time kStamp = Time::from_ns(1'700'000'000'000'000'000);
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

template <class T>
void put(Bytes& data, std::size_t at, T value) {
  std::memcpy(data.data() + at, &value, sizeof(T));
}

CloudFormat decided(const CloudView& cloud, const CloudFormatOptions& options = {}) {
  const auto format = decide_cloud_format(std::span(&cloud, 1), options);
  EXPECT_TRUE(format.has_value()) << (format ? "" : format.error().message());
  return format.value_or(CloudFormat{});
}

TEST(DecodeCloud, drops_and_counts_invalid_and_out_of_range_points) {
  PackedCloud cloud = pack_cloud(vlp16_scan(kStamp), "", CloudStyle::kVelodyne);
  const CloudFormat format = decided(cloud.view);
  const std::size_t n = cloud.view.width;
  put(cloud.data, 0 * 22, kNan);
  put(cloud.data, 1 * 22 + 4, kNan);
  put(cloud.data, 2 * 22 + 8, kNan);
  for (std::size_t k = 0; k < 3; ++k) put(cloud.data, 3 * 22 + 4 * k, 0.0F);
  put(cloud.data, 4 * 22, kInf);   // out of range, not "no number"
  put(cloud.data, 5 * 22, 1e30F);  // its square overflows float
  for (std::size_t k = 0; k < 3; ++k) put(cloud.data, 6 * 22 + 4 * k, 0.1F);  // below 0.4 m
  LidarScan scan;
  ASSERT_TRUE(decode_cloud(cloud.view, format, {}, scan).has_value());
  EXPECT_EQ(scan.dropped_nan, 4U);
  EXPECT_EQ(scan.dropped_range, 3U);
  EXPECT_EQ(scan.size(), n - 7);
  EXPECT_EQ(scan.ring[0], 7);  // the eighth point of the first column
  EXPECT_EQ(scan.ring.size(), scan.dt_s.size());
  EXPECT_EQ(scan.intensity[0], 7.0F);
}

TEST(DecodeCloud, keeps_points_at_the_range_limits_and_removes_the_self_box) {
  LidarScan made;
  made.push_back(0.5F, 0, 0, 0, 0, 0);
  made.push_back(2.0F, 0, 0, 0, 0, 0);
  made.push_back(2.1F, 0, 0, 0, 0, 0);
  made.push_back(-0.6F, 0.1F, 0, 0, 0, 0);
  made.t_start = made.t_end = kStamp;
  const PackedCloud cloud = pack_cloud(made, "", CloudStyle::kXyzi);
  CloudFormatOptions options;
  options.range_m = {0.5, 2.0};
  options.self_box_lidar_m = {-1.0, 0.0, -0.5, 0.5, -0.5, 0.5};
  LidarScan scan;
  ASSERT_TRUE(decode_cloud(cloud.view, decided(cloud.view), options, scan).has_value());
  ASSERT_EQ(scan.size(), 2U);
  EXPECT_EQ(scan.x_m[0], 0.5F);
  EXPECT_EQ(scan.x_m[1], 2.0F);
  EXPECT_EQ(scan.dropped_range, 2U);
  EXPECT_EQ(scan.dropped_nan, 0U);
}

TEST(DecodeCloud, drops_points_with_implausible_times_without_shifting_others) {
  PackedCloud cloud = pack_cloud(vlp16_scan(kStamp), "", CloudStyle::kRoboSense);
  const CloudFormat format = decided(cloud.view);
  const std::size_t n = cloud.view.width;
  put(cloud.data, 10 * 26 + 18, 0.0);
  put(cloud.data, 11 * 26 + 18, std::numeric_limits<double>::quiet_NaN());
  put(cloud.data, 12 * 26 + 18, 1e300);
  put(cloud.data, 13 * 26 + 18, kStamp.s() + 3600.0);
  LidarScan scan;
  ASSERT_TRUE(decode_cloud(cloud.view, format, {}, scan).has_value());
  EXPECT_EQ(scan.dropped_time, 4U);
  EXPECT_EQ(scan.size(), n - 4);
  EXPECT_EQ(scan.ring[10], 14);
  EXPECT_NEAR(seconds_between(kStamp, scan.t_start), 0.0, 1e-6);
  EXPECT_NEAR(seconds_between(kStamp, scan.t_end), 0.0999, 1e-4);
}

TEST(DecodeCloud, a_scan_without_any_valid_time_is_empty) {
  PackedCloud cloud = pack_cloud(vlp16_scan(kStamp), "", CloudStyle::kVelodyne);
  const CloudFormat format = decided(cloud.view);
  for (const float wrong : {kNan, 1e9F, -kInf}) {
    for (std::size_t i = 0; i < cloud.view.width; ++i) put(cloud.data, i * 22 + 18, wrong);
    LidarScan scan;
    ASSERT_TRUE(decode_cloud(cloud.view, format, {}, scan).has_value());
    EXPECT_EQ(scan.size(), 0U);
    EXPECT_EQ(scan.dropped_time, cloud.view.width);
    EXPECT_EQ(scan.t_start, kStamp);
  }
}

TEST(DecodeCloud, padded_rows_organised_clouds_and_gaps_give_the_same_points) {
  // 16 rows of 100 columns, row-major, rows padded by 40 bytes: rings are the rows
  const LidarScan made = vlp16_scan(kStamp, 100);
  constexpr std::uint32_t kRow = 100 * 32 + 40;
  PackedCloud cloud = pack_cloud(made, "", CloudStyle::kVelodynePcl);
  Bytes padded(16 * kRow - 40, std::byte{0xFF});
  for (std::size_t i = 0; i < made.size(); ++i) {
    const std::size_t at = made.ring[i] * kRow + i / 16 * 32;
    std::copy_n(cloud.data.begin() + static_cast<std::ptrdiff_t>(i * 32), 32,
                padded.begin() + static_cast<std::ptrdiff_t>(at));
  }
  cloud.view.height = 16;
  cloud.view.width = 100;
  cloud.view.row_step = kRow;
  cloud.view.data = padded;
  cloud.view.fields[4].name = "not_a_ring";
  const CloudFormat format = decided(cloud.view);
  EXPECT_EQ(format.ring_from, RingFrom::kRow) << format.summary;
  EXPECT_EQ(format.model, "vlp16");
  LidarScan scan;
  ASSERT_TRUE(decode_cloud(cloud.view, format, {}, scan).has_value());
  ASSERT_EQ(scan.size(), made.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const std::size_t from = i % 100 * 16 + i / 100;
    ASSERT_EQ(scan.x_m[i], made.x_m[from]);
    ASSERT_EQ(scan.ring[i], made.ring[from]);
  }
}

TEST(DecodeCloud, columns_are_rings_if_height_and_width_are_swapped) {
  PackedCloud cloud = pack_cloud(vlp16_scan(kStamp, 200), "", CloudStyle::kXyzi);
  cloud.view.height = 200;
  cloud.view.width = 16;
  cloud.view.row_step = 16 * 16;
  const CloudFormat format = decided(cloud.view);
  EXPECT_EQ(format.ring_from, RingFrom::kColumn);
  LidarScan scan;
  ASSERT_TRUE(decode_cloud(cloud.view, format, {}, scan).has_value());
  EXPECT_EQ(scan.ring[5], 5);
  EXPECT_EQ(scan.ring[16], 0);
}

TEST(DecodeCloud, double_coordinates_and_odd_offsets_are_read) {
  const LidarScan made = vlp16_scan(kStamp, 50);
  for (const bool big_endian : {false, true}) {
    CloudView cloud;
    cloud.stamp = kStamp;
    cloud.height = 1;
    cloud.width = static_cast<std::uint32_t>(made.size());
    cloud.point_step = 33;
    cloud.big_endian = big_endian;
    cloud.fields = {{"z", 17, FieldType::kFloat64, 1},
                    {"x", 1, FieldType::kFloat64, 1},
                    {"y", 9, FieldType::kFloat64, 1},
                    {"ring", 0, FieldType::kUint8, 1},
                    {"time", 25, FieldType::kFloat64, 0}};  // count 0: taken as one
    Bytes data(made.size() * 33);
    const auto store = [&](std::size_t at, double value) {
      put(data, at, big_endian ? byte_swapped(value) : value);
    };
    for (std::size_t i = 0; i < made.size(); ++i) {
      data[i * 33] = static_cast<std::byte>(made.ring[i]);
      store(i * 33 + 1, static_cast<double>(made.x_m[i]));
      store(i * 33 + 9, static_cast<double>(made.y_m[i]));
      store(i * 33 + 17, static_cast<double>(made.z_m[i]));
      store(i * 33 + 25, static_cast<double>(made.dt_s[i]));
    }
    cloud.data = data;
    LidarScan scan;
    ASSERT_TRUE(decode_cloud(cloud, decided(cloud), {}, scan).has_value());
    EXPECT_EQ(scan.x_m, made.x_m);
    EXPECT_EQ(scan.y_m, made.y_m);
    EXPECT_EQ(scan.z_m, made.z_m);
    EXPECT_EQ(scan.ring, made.ring);
  }
}

TEST(DecodeCloud, one_return_per_pulse_is_kept) {
  // each pulse twice, the second 1 m farther, types 1 and 2; every tenth alone as type 6
  const LidarScan made = vlp16_scan(kStamp, 300);
  LidarScan dual;
  std::vector<std::uint8_t> types;
  for (std::size_t i = 0; i < made.size(); ++i) {
    const bool alone = i % 10 == 0;
    dual.push_back(made.x_m[i], made.y_m[i], made.z_m[i], 0, made.dt_s[i], made.ring[i]);
    types.push_back(alone ? 6 : 1);
    if (alone) continue;
    dual.push_back(made.x_m[i] * 1.2F, made.y_m[i] * 1.2F, made.z_m[i] * 1.2F, 0, made.dt_s[i],
                   made.ring[i]);
    types.push_back(2);
  }
  dual.t_start = kStamp;
  PackedCloud cloud = pack_cloud(dual, "", CloudStyle::kOuster);
  cloud.view.fields.push_back({"return_type", 40, FieldType::kUint8, 1});
  for (std::size_t i = 0; i < types.size(); ++i) {
    cloud.data[i * 48 + 40] = static_cast<std::byte>(types[i]);
  }
  LidarScan scan;
  ASSERT_TRUE(decode_cloud(cloud.view, decided(cloud.view), {}, scan).has_value());
  EXPECT_EQ(scan.x_m, made.x_m);
  EXPECT_EQ(scan.dropped_return, dual.size() - made.size());
  CloudFormatOptions all;
  all.returns = Returns::kAll;
  ASSERT_TRUE(decode_cloud(cloud.view, decided(cloud.view, all), all, scan).has_value());
  EXPECT_EQ(scan.size(), dual.size());
}

// Drivers number returns differently: the points show which is stronger or farther.
TEST(DecodeCloud, the_stronger_or_the_farther_of_two_returns_is_kept) {
  const LidarScan made = vlp16_scan(kStamp, 300);
  LidarScan dual, near, far;
  std::vector<std::uint8_t> types;
  for (std::size_t i = 0; i < made.size(); ++i) {
    const float x = made.x_m[i], y = made.y_m[i], z = made.z_m[i], dt = made.dt_s[i];
    near.push_back(x, y, z, 90, dt, made.ring[i]);
    far.push_back(x * 1.2F, y * 1.2F, z * 1.2F, 20, dt, made.ring[i]);
    dual.push_back(x, y, z, 90, dt, made.ring[i]);
    types.push_back(7);
    dual.push_back(x * 1.2F, y * 1.2F, z * 1.2F, 20, dt, made.ring[i]);
    types.push_back(2);
  }
  dual.t_start = kStamp;
  PackedCloud cloud = pack_cloud(dual, "", CloudStyle::kOuster);
  cloud.view.fields.push_back({"return_type", 40, FieldType::kUint8, 1});
  for (std::size_t i = 0; i < types.size(); ++i) {
    cloud.data[i * 48 + 40] = static_cast<std::byte>(types[i]);
  }
  LidarScan scan;
  CloudFormatOptions options;
  options.returns = Returns::kStrongest;
  ASSERT_TRUE(decode_cloud(cloud.view, decided(cloud.view, options), options, scan));
  EXPECT_EQ(scan.x_m, near.x_m);
  options.returns = Returns::kLast;
  ASSERT_TRUE(decode_cloud(cloud.view, decided(cloud.view, options), options, scan));
  EXPECT_EQ(scan.x_m, far.x_m);
  EXPECT_NE(decided(cloud.view, options).summary.find("the farther of two"), std::string::npos);
}

TEST(DecodeCloud, a_configured_return_without_a_return_field_is_reported) {
  const PackedCloud cloud = pack_cloud(vlp16_scan(kStamp), "", CloudStyle::kVelodyne);
  CloudFormatOptions options;
  options.returns = Returns::kLast;
  const CloudFormat format = decided(cloud.view, options);
  const auto named = std::find_if(
      format.findings.begin(), format.findings.end(),
      [](const Finding& f) { return f.text.find("names the return") != std::string::npos; });
  EXPECT_NE(named, format.findings.end());
}

TEST(DecodeCloud, contradictory_layouts_are_refused_with_their_numbers) {
  const PackedCloud good = pack_cloud(vlp16_scan(kStamp), "", CloudStyle::kVelodyne);
  const CloudFormat format = decided(good.view);
  const auto error_of = [&](const auto& change) {
    CloudView cloud = good.view;
    change(cloud);
    LidarScan scan;
    const Status status = decode_cloud(cloud, format, {}, scan);
    const auto decision = decide_cloud_format(std::span(&cloud, 1), {});
    EXPECT_EQ(status.has_value(), decision.has_value());
    return status ? std::string() : status.error().what;
  };
  EXPECT_NE(error_of([](CloudView& c) { c.point_step = 0; }), "");
  EXPECT_NE(error_of([](CloudView& c) { c.width = c.height = 0xFFFFFFFF; }), "");
  EXPECT_EQ(error_of([](CloudView& c) { c.width = 20'000; }),
            "a cloud claims 20000 x 1 points of 22 bytes, but has 316800 bytes");
  EXPECT_NE(error_of([](CloudView& c) { c.data = c.data.first(c.data.size() - 1); }), "");
  EXPECT_NE(error_of([](CloudView& c) { c.data = {}; }), "");
  EXPECT_NE(error_of([](CloudView& c) {
              c.height = 2;
              c.width = 7200;
              c.row_step = 0xFFFFFFFF;
            }),
            "");
  EXPECT_EQ(error_of([](CloudView& c) { c.row_step = 7; }), "");  // stale but unused in one row
}

TEST(DecodeCloud, fields_beyond_the_point_size_are_ignored) {
  PackedCloud cloud = pack_cloud(vlp16_scan(kStamp), "", CloudStyle::kVelodyne);
  cloud.view.fields[5].offset = 19;  // time would extend into the next point
  cloud.view.fields[4].type = static_cast<FieldType>(9);
  cloud.view.fields[3].offset = 0xFFFFFFFF;
  const CloudFormat format = decided(cloud.view);
  EXPECT_EQ(format.time, -1);
  EXPECT_EQ(format.ring, -1);
  EXPECT_EQ(format.intensity, -1);
  // and a cloud whose fields change later is refused, not misread
  PackedCloud other = pack_cloud(vlp16_scan(kStamp), "", CloudStyle::kXyzi);
  const CloudFormat velodyne =
      decided(pack_cloud(vlp16_scan(kStamp), "", CloudStyle::kVelodyne).view);
  LidarScan scan;
  EXPECT_FALSE(decode_cloud(other.view, velodyne, {}, scan).has_value());
}

TEST(DecodeCloud, an_empty_cloud_gives_an_empty_scan_at_its_stamp) {
  const PackedCloud good = pack_cloud(vlp16_scan(kStamp), "", CloudStyle::kVelodyne);
  const CloudFormat format = decided(good.view);
  CloudView empty = good.view;
  empty.width = 0;
  empty.data = {};
  LidarScan scan = vlp16_scan(Time{});
  ASSERT_TRUE(decode_cloud(empty, format, {}, scan).has_value());
  EXPECT_EQ(scan.size(), 0U);
  EXPECT_EQ(scan.t_start, kStamp);
  EXPECT_EQ(scan.t_end, kStamp);
}

TEST(DecodeCloud, ring_numbers_are_clamped_to_the_number_of_rings) {
  PackedCloud cloud = pack_cloud(vlp16_scan(kStamp), "", CloudStyle::kVelodyne);
  const CloudFormat format = decided(cloud.view);
  put(cloud.data, 16, std::uint16_t{65'535});
  LidarScan scan;
  ASSERT_TRUE(decode_cloud(cloud.view, format, {}, scan).has_value());
  EXPECT_EQ(scan.ring[0], 15);
  EXPECT_EQ(scan.rings, 16);
}

}  // namespace
}  // namespace rali::wire
