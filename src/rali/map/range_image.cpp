#include "rali/map/range_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace rali::map {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kColumnPitch_rad = 2.0F * kPi / 900.0F;
constexpr int kRowsUnknown = 32;  ///< sensors without ring numbers
constexpr int kRowsMax = 256;
constexpr float kRowPitchMin_rad = 0.002F;
/// Nearer returns are the vehicle itself, and places nearer than this fill too many pixels.
constexpr double kNearest_m = 1.0;
constexpr int kNeighboursMax = 6;

int rings_of(const KeyframeView& keyframe) {
  if (keyframe.ring.empty()) return 0;
  return 1 + *std::max_element(keyframe.ring.begin(), keyframe.ring.end());
}

}  // namespace

void RangeImage::build(const KeyframeView& keyframe) {
  const geometry::SE3 T_lidar_body = keyframe.T_body_lidar.inverse();
  rays_.clear();
  for (std::size_t i = 0; i < keyframe.size(); ++i) {
    const geometry::Vec3f p = (T_lidar_body * keyframe.point_body(i)).cast<float>();
    const float range_m = p.norm();
    if (!std::isfinite(range_m) || range_m < static_cast<float>(kNearest_m)) continue;
    rays_.push_back(
        {range_m, std::atan2(p.y(), p.x()), std::asin(std::clamp(p.z() / range_m, -1.0F, 1.0F))});
  }
  fit(keyframe);
  pixels_.assign(static_cast<std::size_t>(rows_) * kColumns, Pixel{});
  for (const Pixel& ray : rays_) {
    const int row = row_of(ray.elevation_rad);
    Pixel& pixel = pixels_[static_cast<std::size_t>(row * kColumns + column_of(ray.azimuth_rad))];
    if (pixel.range_m == 0.0F || ray.range_m < pixel.range_m) pixel = ray;
  }
}

void RangeImage::fit(const KeyframeView& keyframe) {
  rows_ = 1;
  ray_spacing_rad_ = std::numeric_limits<double>::infinity();
  if (rays_.empty()) return;
  float low = rays_.front().elevation_rad, high = low;
  std::array<bool, 360> degrees{};
  for (const Pixel& ray : rays_) {
    low = std::min(low, ray.elevation_rad);
    high = std::max(high, ray.elevation_rad);
    const auto degree = static_cast<int>((ray.azimuth_rad + kPi) * (180.0F / kPi));
    degrees[static_cast<std::size_t>(std::clamp(degree, 0, 359))] = true;
  }
  const int rings = rings_of(keyframe);
  rows_ = std::clamp(rings > 1 ? rings : kRowsUnknown, 2, kRowsMax);
  row_pitch_rad_ = std::max((high - low) / static_cast<float>(rows_ - 1), kRowPitchMin_rad);
  elevation_min_rad_ = low;
  const double seen_deg = static_cast<double>(std::count(degrees.begin(), degrees.end(), true));
  ray_spacing_rad_ =
      seen_deg * std::numbers::pi / 180.0 * rows_ / static_cast<double>(rays_.size());
}

int RangeImage::row_of(float elevation_rad) const {
  const float row = std::floor((elevation_rad - elevation_min_rad_) / row_pitch_rad_ + 0.5F);
  return static_cast<int>(std::clamp(row, 0.0F, static_cast<float>(rows_ - 1)));
}

int RangeImage::column_of(float azimuth_rad) {
  const auto column = static_cast<int>((azimuth_rad + kPi) / kColumnPitch_rad);
  return (column % kColumns + kColumns) % kColumns;
}

Sight RangeImage::look(const geometry::Vec3& p_lidar_m, const SightLimits& limits) const {
  const double range_m = p_lidar_m.norm();
  if (pixels_.empty() || !(range_m > kNearest_m) || range_m > limits.range_m)
    return Sight::kUnknown;
  const geometry::Vec3f p = p_lidar_m.cast<float>();
  const auto r = static_cast<float>(range_m);
  const float azimuth = std::atan2(p.y(), p.x());
  const float elevation = std::asin(std::clamp(p.z() / r, -1.0F, 1.0F));
  const float row = (elevation - elevation_min_rad_) / row_pitch_rad_;
  if (row < -1.0F || row > static_cast<float>(rows_)) return Sight::kUnknown;

  const auto margin = static_cast<float>(limits.margin_m);
  const auto radius = static_cast<float>(limits.radius_m);
  const auto beside = static_cast<float>(limits.beside_m);
  const auto depth = static_cast<float>(limits.depth_m);
  const float cos_elevation = std::max(std::cos(elevation), 0.05F);
  const auto reach = [radius, r](float pitch) {
    return std::min(1 + static_cast<int>(radius / (r * pitch)), kNeighboursMax);
  };
  const int row_reach = reach(row_pitch_rad_);
  const int column_reach = reach(kColumnPitch_rad * cos_elevation);
  const int row0 = row_of(elevation), column0 = column_of(azimuth);
  bool hit = false, near = false, passed = false;
  for (int i = std::max(row0 - row_reach, 0); i <= std::min(row0 + row_reach, rows_ - 1); ++i) {
    for (int j = column0 - column_reach; j <= column0 + column_reach; ++j) {
      const int column = (j + kColumns) % kColumns;
      const Pixel& pixel = pixels_[static_cast<std::size_t>(i * kColumns + column)];
      if (pixel.range_m == 0.0F) continue;
      const float across = std::remainder(pixel.azimuth_rad - azimuth, 2.0F * kPi) * cos_elevation;
      const float miss_m = r * std::hypot(across, pixel.elevation_rad - elevation);
      const bool behind = pixel.range_m > r + margin;
      passed = passed || (behind && miss_m <= radius);
      near = near || !behind;
      hit = hit || (std::abs(pixel.range_m - r) <= depth && miss_m <= beside);
    }
  }
  if (hit) return Sight::kHit;
  const bool dense = range_m * ray_spacing_rad_ <= limits.thin_m;
  return passed && !near && dense ? Sight::kPassed : Sight::kUnknown;
}

}  // namespace rali::map
