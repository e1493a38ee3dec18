#include "rali/wire/internal/first_clouds.hpp"

#include <algorithm>
#include <cmath>

namespace rali::wire::internal {
namespace {

// Enough for clusters of 128 elevations; 10 such clouds are processed in a few milliseconds.
constexpr std::size_t kSampleMax = 40'000;
constexpr std::size_t kCloudsMax = 10;
// Scans between 1 Hz and 50 Hz; other intervals of stamps are gaps, batches or repeats.
constexpr double kPeriodMinS = 0.02, kPeriodMaxS = 1.0;

FirstClouds::Cloud sample(const CloudView& view, const CloudLayout& layout,
                          const FirstClouds& first) {
  FirstClouds::Cloud cloud;
  cloud.view = &view;
  cloud.layout = layout;
  cloud.stride = (layout.points + kSampleMax - 1) / kSampleMax;
  cloud.x_m = field_values(view, layout, first.x, cloud.stride);
  cloud.y_m = field_values(view, layout, first.y, cloud.stride);
  cloud.z_m = field_values(view, layout, first.z, cloud.stride);
  cloud.valid.resize(cloud.x_m.size());
  for (std::size_t i = 0; i < cloud.valid.size(); ++i) {
    const double x = cloud.x_m[i], y = cloud.y_m[i], z = cloud.z_m[i];
    const double range2 = x * x + y * y + z * z;
    const bool valid = range2 > 1e-6 && range2 < 1e8;
    cloud.valid[i] = valid ? 1 : 0;
    cloud.valid_count += valid ? 1U : 0U;
  }
  return cloud;
}

double stamp_period(const std::vector<FirstClouds::Cloud>& clouds) {
  std::vector<double> distances_s;
  for (std::size_t i = 1; i < clouds.size(); ++i) {
    const double distance_s = seconds_between(clouds[i - 1].view->stamp, clouds[i].view->stamp);
    if (distance_s >= kPeriodMinS && distance_s <= kPeriodMaxS) distances_s.push_back(distance_s);
  }
  return median(distances_s);
}

bool same_fields(const CloudView& a, const CloudView& b) {
  return std::equal(a.fields.begin(), a.fields.end(), b.fields.begin(), b.fields.end(),
                    [](const CloudField& f, const CloudField& g) {
                      return f.name == g.name && f.offset == g.offset && f.type == g.type;
                    });
}

}  // namespace

double median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Result<FirstClouds> look_at(std::span<const CloudView> clouds) {
  FirstClouds first;
  for (const CloudView& view : clouds) {
    const Result<CloudLayout> layout = cloud_layout(view);
    if (!layout) return tl::make_unexpected(layout.error());
    if (layout->points == 0) continue;
    if (first.clouds.empty()) {
      first.x = find_field(view, "x");
      first.y = find_field(view, "y");
      first.z = find_field(view, "z");
      if (first.x < 0 || first.y < 0 || first.z < 0) {
        return fail(ErrorCode::kInput, {}, "the clouds have no fields x, y, z");
      }
    } else if (!same_fields(view, *first.clouds[0].view)) {
      continue;  // decided by the first; decode_cloud refuses others
    }
    first.clouds.push_back(sample(view, *layout, first));
    if (first.clouds.size() == kCloudsMax) break;
  }
  if (first.clouds.empty()) {
    return fail(ErrorCode::kNoAnswer, {}, "the first clouds have no points");
  }
  first.stamp_period_s = stamp_period(first.clouds);
  return first;
}

}  // namespace rali::wire::internal
