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
// No LiDAR of cars or robots has a longer range; bytes misread as floats are mostly far beyond.
constexpr float kFarthest_m = 1000.0F;
// A scan has some point farther than this; a list of times or angles has not.
constexpr float kNearest_m = 1.0F;
// Sensors give a few points odd intensities; a larger fraction means another layout.
constexpr double kOddFractionMax = 0.05;

/// Plausibility of a layout, from its numbers.
struct Plausibility {
  double far_fraction = 0.0;            ///< points with a coordinate beyond any LiDAR's range
  double odd_intensity_fraction = 0.0;  ///< points whose 4th value is no plausible intensity
  float largest_m = 0.0F;

  [[nodiscard]] bool is_scan() const {
    return far_fraction <= kOddFractionMax && largest_m > kNearest_m;
  }
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
    // NaN marks a missing return in some files; it is neutral for the layout.
    if (reach > kFarthest_m) {
      ++far;
    } else if (reach > seen.largest_m) {
      seen.largest_m = reach;
    }
    if (!(v[3] >= 0.0F && v[3] <= 65535.0F)) ++odd;
  }
  seen.far_fraction = n > 0 ? static_cast<double>(far) / static_cast<double>(n) : 0.0;
  seen.odd_intensity_fraction = n > 0 ? static_cast<double>(odd) / static_cast<double>(n) : 0.0;
  return seen;
}

/// An error if the numbers are not x y z intensity; otherwise nothing.
Status check_layout(const std::vector<std::byte>& bytes, const std::string& path) {
  const Plausibility as16 = examine(bytes, kPoint16);
  if (as16.is_scan() && as16.odd_intensity_fraction <= kOddFractionMax) return {};
  const Plausibility as12 = examine(bytes, kPoint12);
  if (bytes.size() % kPoint12 == 0 && as12.is_scan()) {
    return fail(ErrorCode::kInput, path,
                fmt::format("looks like x y z without intensity (12 bytes a point): read as KITTI "
                            "x y z intensity, {:.0f} % of the intensities are negative or absurd",
                            100.0 * as16.odd_intensity_fraction),
                "If it is, say that its layout is xyz.");
  }
  return fail(ErrorCode::kInput, path,
              fmt::format("is no LiDAR scan of float32 x y z intensity: largest coordinate {:.3g} "
                          "m, {:.0f} % of the points beyond {:.0f} m, {:.0f} % odd intensities",
                          static_cast<double>(as16.largest_m), 100.0 * as16.far_fraction,
                          static_cast<double>(kFarthest_m), 100.0 * as16.odd_intensity_fraction));
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
