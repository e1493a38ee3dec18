#include "rali/wire/internal/ring_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "rali/sensor/lidar_models.hpp"
#include "rali/wire/internal/time_choice.hpp"

namespace rali::wire::internal {
namespace {

constexpr std::array<std::string_view, 8> kRingNames = {
    "ring", "line", "channel", "ring_id", "laser_id", "laser", "scan_line", "ring_index"};

/// Laser counts of existing sensors; a count in between means that some lasers had no returns.
constexpr std::array<int, 13> kUsualRings = {1, 2, 4, 6, 8, 16, 32, 40, 48, 64, 80, 96, 128};
constexpr int kRingsMax = 1024;

constexpr float kRad = std::numbers::pi_v<float> / 180.0F;

int rounded_up(int rings) {
  for (const int usual : kUsualRings) {
    if (rings <= usual) return usual;
  }
  return rings;
}

/// Median elevation of the points of each ring, if it has at least a few.
struct RingField {
  int largest = -1;
  bool whole = true;  ///< integers from 0 to kRingsMax
  std::vector<std::optional<float>> elevation_rad;
};

float elevation_of(const FirstClouds::Cloud& cloud, std::size_t i) {
  return static_cast<float>(std::atan2(cloud.z_m[i], std::hypot(cloud.x_m[i], cloud.y_m[i])));
}

template <class RingOf>
RingField ring_elevations(const FirstClouds& first, const RingOf& ring_of) {
  RingField rings;
  std::vector<std::vector<double>> elevations(kRingsMax + 1);
  for (const FirstClouds::Cloud& cloud : first.clouds) {
    for (std::size_t i = 0; i < cloud.valid.size(); ++i) {
      if (cloud.valid[i] == 0) continue;
      const double value = ring_of(cloud, i);
      if (!(value >= 0.0 && value <= kRingsMax) || value != std::floor(value)) {
        rings.whole = false;
        return rings;
      }
      const int ring = static_cast<int>(value);
      rings.largest = std::max(rings.largest, ring);
      elevations[static_cast<std::size_t>(ring)].push_back(
          static_cast<double>(elevation_of(cloud, i)));
    }
  }
  constexpr std::size_t kPointsMin = 5;
  for (int ring = 0; ring <= rings.largest; ++ring) {
    std::vector<double>& values = elevations[static_cast<std::size_t>(ring)];
    std::optional<float> middle;
    if (values.size() >= kPointsMin) middle = static_cast<float>(median(values));
    rings.elevation_rad.push_back(middle);
  }
  return rings;
}

RingField read_ring_field(const FirstClouds& first, int field) {
  std::vector<std::vector<double>> values;
  for (const FirstClouds::Cloud& cloud : first.clouds) {
    values.push_back(field_values(*cloud.view, cloud.layout, field, cloud.stride));
  }
  return ring_elevations(first, [&](const FirstClouds::Cloud& cloud, std::size_t i) {
    return values[static_cast<std::size_t>(&cloud - first.clouds.data())][i];
  });
}

/// Livox sensors move their few lines over the whole field of view: rings, but no elevations.
bool looks_like_livox(const FirstClouds& first) {
  const CloudView& view = *first.clouds[0].view;
  return find_field(view, "line") >= 0 && find_field(view, "tag") >= 0;
}

bool by_elevation(const RingField& rings) {
  int up = 0, down = 0;
  std::optional<float> last;
  for (const auto& elevation : rings.elevation_rad) {
    if (!elevation) continue;
    if (last) ++(*elevation > *last ? up : down);
    last = elevation;
  }
  return up == 0 || down == 0;
}

std::vector<float> sorted_elevations(const RingField& rings) {
  std::vector<float> sorted;
  for (const auto& elevation : rings.elevation_rad) {
    if (elevation) sorted.push_back(*elevation);
  }
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

void guess_model(std::span<const float> elevations_rad, const CloudFormatOptions& options,
                 CloudFormat& format) {
  if (options.model != "auto") return;
  const sensor::LidarModel* found = sensor::identify_lidar(elevations_rad);
  if (found != nullptr) format.model = std::string(found->name);
}

bool take_ring_field(const FirstClouds& first, const CloudFormatOptions& options,
                     CloudFormat& format, std::string& reported) {
  for (const std::string_view name : kRingNames) {
    const int field = find_field(*first.clouds[0].view, name);
    if (field < 0) continue;
    const RingField rings = read_ring_field(first, field);
    if (!rings.whole || rings.largest < 0) {
      format.findings.push_back(cloud_finding(
          "D06", Severity::kWarning,
          fmt::format("field '{}' holds no ring numbers (not whole, negative or above {})", name,
                      kRingsMax),
          "rings are taken from elsewhere", {}));
      continue;
    }
    const bool livox = looks_like_livox(first);
    const sensor::LidarModel* model = sensor::find_lidar_model(options.model);
    const bool one_line = livox || (model != nullptr && model->lines == 1);
    if (rings.largest == 0 && !one_line) {
      format.findings.push_back(cloud_finding("D06", Severity::kWarning,
                                              fmt::format("field '{}' is 0 in every point", name),
                                              "rings are taken from elsewhere", {}));
      continue;
    }
    format.ring = field;
    format.ring_from = RingFrom::kField;
    format.rings = static_cast<std::uint16_t>(rounded_up(rings.largest + 1));
    reported = fmt::format("ring: field '{}' 0..{}", name, rings.largest);
    if (livox) {
      if (options.model == "auto") format.model = format.rings == 4 ? "mid360" : "generic";
      return true;
    }
    guess_model(sorted_elevations(rings), options, format);
    if (!by_elevation(rings)) {
      reported += " (not in order of elevation)";
      format.findings.push_back(cloud_finding(
          "D06", Severity::kInfo,
          fmt::format("field '{}' does not number the rings by elevation: fine", name), {}, {}));
    }
    return true;
  }
  return false;
}

/// An organised cloud whose rows (or columns) each keep one elevation.
bool take_rows(const FirstClouds& first, const CloudFormatOptions& options, CloudFormat& format,
               std::string& reported) {
  const CloudLayout& layout = first.clouds[0].layout;
  const std::size_t lines = std::min(layout.rows, layout.columns);
  if (lines < 8 || lines > 256) return false;
  const bool rows = layout.rows == lines;
  const RingField rings =
      ring_elevations(first, [&](const FirstClouds::Cloud& cloud, std::size_t i) {
        const std::size_t point = i * cloud.stride;
        const std::size_t columns = cloud.layout.columns;
        return static_cast<double>(rows ? point / columns : point % columns);
      });
  if (!rings.whole) return false;
  // Different rows must be different elevations; rows of a plain image-like cloud drift.
  const std::vector<float> sorted = sorted_elevations(rings);
  if (sorted.size() < lines / 2) return false;
  std::size_t distinct = 0;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    distinct += sorted[i] - sorted[i - 1] > 0.1F * kRad ? 1U : 0U;
  }
  if (distinct + 1 < sorted.size() * 3 / 4) return false;
  format.ring_from = rows ? RingFrom::kRow : RingFrom::kColumn;
  format.rings = static_cast<std::uint16_t>(lines);
  reported =
      fmt::format("ring: {} of the organised cloud 0..{}", rows ? "row" : "column", lines - 1);
  guess_model(sorted, options, format);
  return true;
}

/// Adds the model's rings without returns, at their design elevations, so that indices are the same
/// in every recording of the sensor.
void complete_rings(const sensor::LidarModel& model, std::vector<float>& elevations_rad) {
  if (elevations_rad.size() >= model.elevations_deg.size()) return;
  std::vector<float> all;
  for (const float deg : model.elevations_deg) all.push_back(deg * kRad);
  for (const float found : elevations_rad) all[sensor::nearest_ring(all, found)] = found;
  elevations_rad = std::move(all);
}

bool take_elevations(const FirstClouds& first, const CloudFormatOptions& options,
                     CloudFormat& format, std::string& reported) {
  const sensor::LidarModel* model = sensor::find_lidar_model(format.model);
  if (model != nullptr && !model->elevations_deg.empty()) {
    for (const float deg : model->elevations_deg) format.ring_elevations_rad.push_back(deg * kRad);
    reported = fmt::format("ring: from elevation by model {}", model->name);
  } else {
    format.ring_elevations_rad = find_elevations(first);
    if (format.ring_elevations_rad.empty()) return false;
    reported = fmt::format("ring: {} found from elevation", format.ring_elevations_rad.size());
    guess_model(format.ring_elevations_rad, options, format);
    model = sensor::find_lidar_model(format.model);
    if (model != nullptr) complete_rings(*model, format.ring_elevations_rad);
  }
  format.ring_from = RingFrom::kElevation;
  format.rings_from_elevation = true;
  format.rings = static_cast<std::uint16_t>(format.ring_elevations_rad.size());
  return true;
}

}  // namespace

std::string choose_rings(const FirstClouds& first, const CloudFormatOptions& options,
                         CloudFormat& format) {
  format.model = options.model == "auto" ? "generic" : options.model;
  std::string reported;
  if (take_ring_field(first, options, format, reported)) return reported;
  if (take_rows(first, options, format, reported)) return reported;
  if (take_elevations(first, options, format, reported)) return reported;
  format.findings.push_back(cloud_finding("D06", Severity::kInfo,
                                          "the clouds have no rings and no discrete elevations",
                                          "the scan is treated as one set of points", {}));
  return "ring: none";
}

}  // namespace rali::wire::internal
