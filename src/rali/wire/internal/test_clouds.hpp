#pragma once

#include <vector>

#include <gtest/gtest.h>

#include "rali/wire/cloud_pack.hpp"
#include "rali/wire/internal/test_scan.hpp"

// Three scans of a VLP-16 in a room, for tests of the cloud decision.
namespace rali::wire::internal {

using sensor::LidarScan;

inline const Time kStart = Time::from_ns(1'700'000'000'123'456'789);
constexpr double kPeriodS = 0.1;

/// Three scans, `kPeriodS` apart, in one layout.
inline std::vector<PackedCloud> three(CloudStyle style, HeaderStamp stamp = HeaderStamp::kStart,
                                      bool big_endian = false) {
  std::vector<PackedCloud> clouds;
  for (int i = 0; i < 3; ++i) {
    const LidarScan scan = vlp16_scan(kStart + Duration::from_s(i * kPeriodS));
    clouds.push_back(pack_cloud(scan, "lidar", style, stamp, big_endian));
  }
  return clouds;
}

inline std::vector<CloudView> views(const std::vector<PackedCloud>& clouds) {
  std::vector<CloudView> found;
  for (const PackedCloud& cloud : clouds) found.push_back(cloud.view);
  return found;
}

inline bool has_finding(const CloudFormat& format, std::string_view id) {
  for (const Finding& finding : format.findings) {
    if (finding.id == id) return true;
  }
  return false;
}

/// The third scan must be decoded with times (to `tolerance_s`) and rings.
inline void expect_third(const CloudView& cloud, const CloudFormat& format,
                         const CloudFormatOptions& options, double tolerance_s) {
  const LidarScan want = vlp16_scan(kStart + Duration::from_s(2 * kPeriodS));
  LidarScan got;
  const Status status = decode_cloud(cloud, format, options, got);
  ASSERT_TRUE(status.has_value()) << status.error().message();
  ASSERT_EQ(got.size(), want.size());
  EXPECT_EQ(got.x_m, want.x_m);
  EXPECT_EQ(got.z_m, want.z_m);
  EXPECT_NEAR(seconds_between(want.t_start, got.t_start), 0.0, tolerance_s);
  EXPECT_NEAR(seconds_between(want.t_end, got.t_end), 0.0, tolerance_s);
  EXPECT_TRUE(got.has_point_times);
  for (std::size_t i = 0; i < got.size(); i += 97) {
    EXPECT_NEAR(static_cast<double>(got.dt_s[i]), static_cast<double>(want.dt_s[i]), tolerance_s);
    EXPECT_GE(got.dt_s[i], 0.0F);
    EXPECT_EQ(got.ring[i], want.ring[i]);
  }
  EXPECT_EQ(got.rings, 16);
}

}  // namespace rali::wire::internal
