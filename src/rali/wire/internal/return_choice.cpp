#include "rali/wire/internal/return_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include <fmt/format.h>

#include "rali/wire/internal/time_choice.hpp"

// The numbers of return types differ between drivers (first, last, strongest, "identical"), so
// their meaning is derived from the points: two points of one direction in one scan are two returns
// of one pulse. Of the types that share a pulse one is kept: the most frequent, or the one that is
// the stronger or the farther of the two in most pulses. A type that is always alone ("identical")
// is kept, too.
namespace rali::wire::internal {
namespace {

constexpr std::array<std::string_view, 5> kReturnNames = {"return_type", "return", "return_id",
                                                          "echo", "return_number"};
constexpr std::size_t kTypes = 32;

/// The direction of a sample point in steps of 0.02 deg: finer than any sensor's grid.
struct Shot {
  std::int32_t azimuth = 0, elevation = 0;
  std::uint32_t type = 0;
  double range_m = 0.0, intensity = 0.0;

  [[nodiscard]] auto direction() const { return std::tie(azimuth, elevation); }
};

std::vector<Shot> shots_of(const FirstClouds::Cloud& cloud, int field, int intensity_field) {
  const std::vector<double> types = field_values(*cloud.view, cloud.layout, field, cloud.stride);
  std::vector<double> intensity;
  if (intensity_field >= 0) {
    intensity = field_values(*cloud.view, cloud.layout, intensity_field, cloud.stride);
  }
  std::vector<Shot> shots;
  shots.reserve(cloud.valid_count);
  constexpr double kStepsPerRad = 50.0 * 180.0 / 3.14159265358979323846;
  for (std::size_t i = 0; i < types.size(); ++i) {
    if (cloud.valid[i] == 0 || !(types[i] >= 0.0 && types[i] < kTypes)) continue;
    const double flat_m = std::hypot(cloud.x_m[i], cloud.y_m[i]);
    shots.push_back(
        {static_cast<std::int32_t>(
             std::lround(std::atan2(cloud.y_m[i], cloud.x_m[i]) * kStepsPerRad)),
         static_cast<std::int32_t>(std::lround(std::atan2(cloud.z_m[i], flat_m) * kStepsPerRad)),
         static_cast<std::uint32_t>(types[i]), std::hypot(flat_m, cloud.z_m[i]),
         i < intensity.size() ? intensity[i] : 0.0});
  }
  std::sort(shots.begin(), shots.end(), [](const Shot& a, const Shot& b) {
    return std::tuple(a.azimuth, a.elevation, a.type) < std::tuple(b.azimuth, b.elevation, b.type);
  });
  return shots;
}

/// Per type: points, and points that share their pulse with another type.
struct Census {
  std::array<std::size_t, kTypes> all{}, shared{};
  std::array<std::size_t, kTypes> stronger{}, farther{};  ///< of the two points of a pulse
};

void count(const std::vector<Shot>& shots, Census& census) {
  for (std::size_t i = 0; i < shots.size(); ++i) {
    const auto same = [&](std::size_t j) {
      return shots[j].direction() == shots[i].direction() && shots[j].type != shots[i].type;
    };
    const bool shared = (i > 0 && same(i - 1)) || (i + 1 < shots.size() && same(i + 1));
    ++census.all[shots[i].type];
    census.shared[shots[i].type] += shared ? 1U : 0U;
    if (i == 0 || !same(i - 1)) continue;
    const Shot &a = shots[i - 1], &b = shots[i];
    ++census.farther[a.range_m > b.range_m ? a.type : b.type];
    ++census.stronger[a.intensity > b.intensity ? a.type : b.type];
  }
}

/// The count by which the kept type is chosen, by option.
const std::array<std::size_t, kTypes>& ranking(const Census& census, Returns returns) {
  if (returns == Returns::kStrongest) return census.stronger;
  return returns == Returns::kLast ? census.farther : census.all;
}

std::string choice_words(Returns returns) {
  if (returns == Returns::kStrongest) return "returns: the stronger of two (set)";
  return returns == Returns::kLast ? "returns: the farther of two (set)" : "returns: one of two";
}

bool must_choose(const CloudFormatOptions& options) {
  return options.returns == Returns::kStrongest || options.returns == Returns::kLast;
}

/// The user set a return, but the clouds have no field for it.
void note_no_field(CloudFormat& format) {
  format.findings.push_back(cloud_finding(
      "D06", Severity::kWarning, "the clouds have no field that names the return of a point",
      "every point is used, whatever lidar.returns asks for",
      "Let the driver publish one return, or its field of return types."));
}

}  // namespace

std::string choose_returns(const FirstClouds& first, const CloudFormatOptions& options,
                           CloudFormat& format) {
  int field = -1;
  for (const std::string_view name : kReturnNames) {
    if (field < 0) field = find_field(*first.clouds[0].view, name);
  }
  if (field < 0) {
    if (must_choose(options)) note_no_field(format);
    return {};
  }
  Census census;
  for (const FirstClouds::Cloud& cloud : first.clouds) {
    if (cloud.stride == 1) count(shots_of(cloud, field, format.intensity), census);
  }
  // Few points share a pulse by chance; most points of a second return do.
  std::size_t best = kTypes;
  const auto second = [&](std::size_t type) {
    return census.all[type] > 0 && 2 * census.shared[type] > census.all[type];
  };
  for (std::size_t type = 0; type < kTypes; ++type) {
    if (!second(type)) continue;
    const auto& rank = ranking(census, options.returns);
    if (best == kTypes || rank[type] > rank[best]) best = type;
  }
  std::uint32_t dropped = 0;
  for (std::size_t type = 0; type < kTypes; ++type) {
    if (second(type) && type != best) dropped |= 1U << type;
  }
  if (dropped == 0) return {};
  format.findings.push_back(cloud_finding(
      "D06", Severity::kInfo, "the clouds hold two returns per laser pulse",
      options.returns == Returns::kAll ? "both are used" : "one of them is used", {}));
  if (options.returns == Returns::kAll) return "returns: all (set)";
  format.return_type = field;
  format.returns_dropped = dropped;
  return choice_words(options.returns);
}

}  // namespace rali::wire::internal
