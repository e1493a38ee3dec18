#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include <fmt/core.h>

#include "rali/io/files/cloud_file.hpp"

namespace rali::io {
namespace {

constexpr std::size_t kPoint16 = 16;
constexpr std::size_t kPoint12 = 12;
// No LiDAR that cars or robots carry sees farther; bytes read as floats mostly are far beyond.
constexpr float kFarthest_m = 1000.0F;
// A sweep has some point beyond arm's length; a list of times or angles has not.
constexpr float kNearest_m = 1.0F;
// Sensors mark a few points with odd intensities; more than this share is another layout.
constexpr double kOddShareMax = 0.05;

/// What the numbers say about a layout.
struct Plausibility {
  double far_share = 0.0;            ///< points with a coordinate that no LiDAR gives
  double odd_intensity_share = 0.0;  ///< points whose 4th value is no intensity
  float largest_m = 0.0F;

  [[nodiscard]] bool is_scan() const { return far_share <= kOddShareMax && largest_m > kNearest_m; }
};

Plausibility examine(const std::vector<std::byte>& bytes, std::size_t step) {
  Plausibility seen;
  const std::size_t n = bytes.size() / step;
  std::size_t far = 0;
  std::size_t odd = 0;
  for (std::size_t i = 0; i < n; ++i) {
    float v[4] = {0.0F, 0.0F, 0.0F, 0.0F};
    std::memcpy(v, bytes.data() + i * step, step);
    const float reach = std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
    // NaN marks a missing return in some files and speaks neither for nor against a layout.
    if (reach > kFarthest_m) {
      ++far;
    } else if (reach > seen.largest_m) {
      seen.largest_m = reach;
    }
    if (!(v[3] >= 0.0F && v[3] <= 65535.0F)) ++odd;
  }
  seen.far_share = n > 0 ? static_cast<double>(far) / static_cast<double>(n) : 0.0;
  seen.odd_intensity_share = n > 0 ? static_cast<double>(odd) / static_cast<double>(n) : 0.0;
  return seen;
}

/// A refusal where the numbers are not x y z intensity; nothing where they are.
Status check_layout(const std::vector<std::byte>& bytes, const std::string& path) {
  const Plausibility as16 = examine(bytes, kPoint16);
  if (as16.is_scan() && as16.odd_intensity_share <= kOddShareMax) return {};
  const Plausibility as12 = examine(bytes, kPoint12);
  if (bytes.size() % kPoint12 == 0 && as12.is_scan()) {
    return fail(ErrorCode::kInput, path,
                fmt::format("looks like x y z without intensity (12 bytes a point): read as KITTI "
                            "x y z intensity, {:.0f} % of the intensities are negative or absurd",
                            100.0 * as16.odd_intensity_share),
                "If it is, say that its layout is xyz.");
  }
  return fail(ErrorCode::kInput, path,
              fmt::format("is no LiDAR scan of float32 x y z intensity: largest coordinate {:.3g} "
                          "m, {:.0f} % of the points beyond {:.0f} m, {:.0f} % odd intensities",
                          static_cast<double>(as16.largest_m), 100.0 * as16.far_share,
                          static_cast<double>(kFarthest_m), 100.0 * as16.odd_intensity_share));
}

}  // namespace

Result<CloudFile> parse_kitti(std::vector<std::byte> bytes, const std::string& path,
                              KittiLayout layout) {
  const std::size_t step = layout == KittiLayout::kXyz ? kPoint12 : kPoint16;
  const std::size_t points = bytes.size() / step;
  if (points == 0) {
    return fail(ErrorCode::kInput, path,
                fmt::format("has {} bytes, less than one point of {}", bytes.size(), step));
  }
  if (bytes.size() > kCloudBytesMax) {
    return fail(ErrorCode::kInput, path, "has more than 4 GiB, too much for one scan");
  }
  if (layout == KittiLayout::kAuto) {
    if (auto status = check_layout(bytes, path); !status) {
      return tl::make_unexpected(status.error());
    }
  }
  CloudFile cloud;
  cloud.kind = CloudFileKind::kKitti;
  cloud.encoding = "binary";
  cloud.width = static_cast<std::uint32_t>(points);
  cloud.point_step = static_cast<std::uint32_t>(step);
  const char* names[] = {"x", "y", "z", "intensity"};
  for (std::uint32_t i = 0; i < step / 4; ++i) {
    cloud.fields.push_back({names[i], 4 * i, wire::FieldType::kFloat32, 1});
  }
  if (const std::size_t rest = bytes.size() % step; rest != 0) {
    Finding finding;
    finding.id = "cloud.cut";
    finding.text = fmt::format("{}: ends {} bytes into a point; its {} whole points are used", path,
                               rest, points);
    finding.value = static_cast<double>(rest);
    cloud.findings.push_back(std::move(finding));
    bytes.resize(points * step);
  }
  cloud.data = std::move(bytes);
  return cloud;
}

}  // namespace rali::io
