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
/// More than the rounding of floats, less than a pixel.
constexpr float kSlack_rad = 1e-4F, kSlack_m = 1e-3F;

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
  pixels_.assign(static_cast<std::size_t>(rows_) * kStride, Pixel{});
  for (const Pixel& ray : rays_) {
    const int column = kNeighboursMax + column_of(ray.azimuth_rad);
    Pixel& pixel = pixels_[static_cast<std::size_t>(row_of(ray.elevation_rad) * kStride + column)];
    if (pixel.range_m == 0.0F || ray.range_m < pixel.range_m) pixel = ray;
  }
  repeat_ends();
}

void RangeImage::repeat_ends() {
  for (int i = 0; i < rows_; ++i) {
    Pixel* row = &pixels_[static_cast<std::size_t>(i * kStride)];
    std::copy_n(row + kColumns, kNeighboursMax, row);
    std::copy_n(row + kNeighboursMax, kNeighboursMax, row + kNeighboursMax + kColumns);
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

/// Pixels beside a place whose rays may touch it.
int RangeImage::reach(float radius_m, float range_m, float pitch_rad) {
  return std::min(1 + static_cast<int>(radius_m / (range_m * pitch_rad)), kNeighboursMax);
}

/// False if no row is near the place.
bool RangeImage::aim_at(const geometry::Vec3f& p_lidar_m, float range_m, float radius_m,
                        Aim& aim) const {
  const float elevation = std::asin(std::clamp(p_lidar_m.z() / range_m, -1.0F, 1.0F));
  const float row = (elevation - elevation_min_rad_) / row_pitch_rad_;
  if (row < -1.0F || row > static_cast<float>(rows_)) return false;
  const int row0 = row_of(elevation), row_reach = reach(radius_m, range_m, row_pitch_rad_);
  aim.range_m = range_m;
  aim.azimuth_rad = std::atan2(p_lidar_m.y(), p_lidar_m.x());
  aim.elevation_rad = elevation;
  aim.cos_elevation = std::max(std::cos(elevation), 0.05F);
  aim.row_begin = std::max(row0 - row_reach, 0);
  aim.row_end = std::min(row0 + row_reach + 1, rows_);
  aim.column = column_of(aim.azimuth_rad);
  aim.column_reach = reach(radius_m, range_m, kColumnPitch_rad * aim.cos_elevation);
  return true;
}

bool RangeImage::may_see(const geometry::Vec3& middle_lidar_m, double ball_m,
                         const SightLimits& limits) const {
  const double distance_m = middle_lidar_m.norm();
  if (pixels_.empty() || distance_m - ball_m > limits.range_m) return false;
  if (distance_m < kNearest_m + 2.0 * ball_m) return true;  // too many pixels to test
  const auto half = static_cast<float>(std::asin(ball_m / distance_m)) + kSlack_rad;
  const auto elevation = static_cast<float>(std::asin(middle_lidar_m.z() / distance_m));
  if ((elevation + half - elevation_min_rad_) / row_pitch_rad_ < -1.0F ||
      (elevation - half - elevation_min_rad_) / row_pitch_rad_ > static_cast<float>(rows_)) {
    return false;
  }
  const float cos_elevation = std::cos(std::abs(elevation) + half);
  if (cos_elevation < 0.2F) return true;  // near the pole the columns converge
  const auto nearest_m = static_cast<float>(distance_m - ball_m);
  const auto radius_m = static_cast<float>(limits.radius_m);
  const float turn = std::asin(std::min(std::sin(half) / std::cos(elevation), 1.0F)) + kSlack_rad;
  const int row_reach = reach(radius_m, nearest_m, row_pitch_rad_);
  Aim aim;
  aim.range_m = nearest_m - static_cast<float>(limits.depth_m) - kSlack_m;
  aim.row_begin = std::max(row_of(elevation - half) - row_reach, 0);
  aim.row_end = std::min(row_of(elevation + half) + row_reach + 1, rows_);
  aim.column = column_of(static_cast<float>(std::atan2(middle_lidar_m.y(), middle_lidar_m.x())));
  aim.column_reach = 1 + static_cast<int>(turn / kColumnPitch_rad) +
                     reach(radius_m, nearest_m, kColumnPitch_rad * cos_elevation);
  return reaches(aim);
}

/// Whether one of the pixels has a return at or beyond aim.range_m.
bool RangeImage::reaches(const Aim& aim) const {
  const int columns = std::min(2 * aim.column_reach + 1, kColumns);
  const int first = (aim.column - aim.column_reach + 2 * kColumns) % kColumns;
  const int before_seam = std::min(columns, kColumns - first);
  const auto far_enough = [&aim](const Pixel& pixel) { return pixel.range_m >= aim.range_m; };
  for (int i = aim.row_begin; i < aim.row_end; ++i) {
    const Pixel* row = &pixels_[static_cast<std::size_t>(i * kStride + kNeighboursMax)];
    if (std::any_of(row + first, row + first + before_seam, far_enough)) return true;
    if (std::any_of(row, row + (columns - before_seam), far_enough)) return true;
  }
  return false;
}

/// Distance at which a pixel's ray misses the place.
float RangeImage::miss_m(const Pixel& pixel, const Aim& aim) {
  float turn = pixel.azimuth_rad - aim.azimuth_rad;
  if (turn > kPi) turn -= 2.0F * kPi;
  if (turn < -kPi) turn += 2.0F * kPi;
  // Doubles cannot overflow here: std::hypot of floats is three times as slow.
  const auto across = static_cast<double>(turn * aim.cos_elevation);
  const auto up = static_cast<double>(pixel.elevation_rad - aim.elevation_rad);
  return aim.range_m * static_cast<float>(std::sqrt(across * across + up * up));
}

Sight RangeImage::look(const geometry::Vec3& p_lidar_m, const SightLimits& limits) const {
  const double range_m = p_lidar_m.norm();
  if (pixels_.empty() || !(range_m > kNearest_m) || range_m > limits.range_m)
    return Sight::kUnknown;
  const auto radius = static_cast<float>(limits.radius_m);
  Aim aim;
  if (!aim_at(p_lidar_m.cast<float>(), static_cast<float>(range_m), radius, aim))
    return Sight::kUnknown;

  const float behind_m = aim.range_m + static_cast<float>(limits.margin_m);
  const auto beside = static_cast<float>(limits.beside_m);
  const auto depth = static_cast<float>(limits.depth_m);
  // Range alone settles most neighbours, so the costlier miss distance is tested last.
  const bool dense = range_m * ray_spacing_rad_ <= limits.thin_m;
  bool may_pass = dense, passed = false;
  for (int i = aim.row_begin; i < aim.row_end; ++i) {
    const Pixel* pixel = &pixels_[static_cast<std::size_t>(i * kStride + kNeighboursMax +
                                                           aim.column - aim.column_reach)];
    const Pixel* end = pixel + 2 * aim.column_reach + 1;
    for (; pixel != end; ++pixel) {
      if (pixel->range_m == 0.0F) continue;
      if (std::abs(pixel->range_m - aim.range_m) <= depth && miss_m(*pixel, aim) <= beside) {
        return Sight::kHit;
      }
      if (!(pixel->range_m > behind_m)) {
        may_pass = false;
      } else if (may_pass && !passed) {
        passed = miss_m(*pixel, aim) <= radius;
      }
    }
  }
  return passed && may_pass ? Sight::kPassed : Sight::kUnknown;
}

}  // namespace rali::map
