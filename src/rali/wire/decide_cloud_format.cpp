#include <array>

#include <fmt/format.h>

#include "rali/sensor/lidar_models.hpp"
#include "rali/wire/cloud_format.hpp"
#include "rali/wire/internal/first_clouds.hpp"
#include "rali/wire/internal/return_choice.hpp"
#include "rali/wire/internal/ring_choice.hpp"
#include "rali/wire/internal/time_choice.hpp"
#include "rali/wire/internal/unit_choice.hpp"

namespace rali::wire {
namespace {

using internal::FirstClouds;

constexpr std::array<std::string_view, 7> kIntensityNames = {
    "intensity", "reflectivity", "reflectance", "intensities", "i", "signal", "scalar_intensity"};

void choose_intensity(const FirstClouds& first, CloudFormat& format) {
  for (const std::string_view name : kIntensityNames) {
    if (format.intensity < 0) {
      format.intensity = internal::find_field(*first.clouds[0].view, name);
    }
  }
}

/// D05: points without values, if there are many.
void judge_points(const FirstClouds& first, CloudFormat& format) {
  std::size_t all = 0, valid = 0;
  for (const FirstClouds::Cloud& cloud : first.clouds) {
    all += cloud.valid.size();
    valid += cloud.valid_count;
  }
  const double fraction = 1.0 - static_cast<double>(valid) / static_cast<double>(all);
  constexpr double kFractionToReport = 0.05, kFractionToWarn = 0.9;
  if (fraction < kFractionToReport) return;
  Finding finding = internal::cloud_finding(
      "D05", fraction > kFractionToWarn ? Severity::kWarning : Severity::kInfo,
      fmt::format("{:.0f} % of the points are NaN or zero: removed", 100.0 * fraction), {}, {});
  finding.value = fraction;
  finding.limit = kFractionToReport;
  format.findings.push_back(std::move(finding));
}

std::string model_reported(const CloudFormatOptions& options, const CloudFormat& format) {
  if (options.model != "auto") return fmt::format("model {} (set)", format.model);
  if (format.model == "generic") return "model not known";
  return fmt::format(
      "model {} (guessed from the {})", format.model,
      sensor::find_lidar_model(format.model)->elevations_deg.empty() ? "fields" : "elevations");
}

Status check_options(const CloudFormatOptions& options) {
  if (options.model != "auto" && sensor::find_lidar_model(options.model) == nullptr) {
    return fail(ErrorCode::kUsage, "lidar.model", fmt::format("no model '{}'", options.model),
                fmt::format("Choose auto, {}.", sensor::lidar_model_names()));
  }
  return {};
}

}  // namespace

Result<CloudFormat> decide_cloud_format(std::span<const CloudView> clouds,
                                        const CloudFormatOptions& options) {
  if (const Status status = check_options(options); !status) {
    return tl::make_unexpected(status.error());
  }
  const Result<FirstClouds> first = internal::look_at(clouds);
  if (!first) return tl::make_unexpected(first.error());
  if (const Status unit = internal::check_unit(*first, options); !unit) {
    return tl::make_unexpected(unit.error());
  }
  CloudFormat format;
  format.x = first->x;
  format.y = first->y;
  format.z = first->z;
  choose_intensity(*first, format);
  judge_points(*first, format);
  Result<std::string> time = internal::choose_time(*first, options, format);
  if (!time) return tl::make_unexpected(time.error());
  const std::string ring = internal::choose_rings(*first, options, format);
  if (time->empty()) *time = internal::choose_azimuth(*first, options, format);
  const std::string returns = internal::choose_returns(*first, options, format);
  format.summary = fmt::format("{}; {}; {}{}", *time, ring, model_reported(options, format),
                               returns.empty() ? "" : "; " + returns);
  return format;
}

}  // namespace rali::wire
