#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <numbers>

#include <fmt/format.h>

#include "rali/wire/cloud_format.hpp"
#include "rali/wire/internal/kept_points.hpp"

// One pass selects the points and writes x y z, with the offset of each kept point; each further
// field is gathered by one typed loop over the kept points. No allocation per point: the arrays of
// `out` grow to the largest cloud once, the list of offsets is one block per cloud.
namespace rali::wire {
namespace {

using internal::AnyXyz;
using internal::choose_points;
using internal::close_up;
using internal::CloudLayout;
using internal::gather;
using internal::Kept;
using internal::Limits;
using internal::PackedXyz;
using sensor::LidarScan;

void drop_returns(const CloudView& cloud, const CloudFormat& format, Kept& kept, LidarScan& out) {
  if (format.return_type < 0 || format.returns_dropped == 0) return;
  gather(cloud, format.return_type, kept, out.ring.data(), [](auto value) {
    const auto v = static_cast<double>(value);
    return static_cast<std::uint16_t>(v >= 0.0 && v < 32.0 ? v : 32.0);
  });
  out.dropped_return = close_up(kept, out, [&](std::size_t i) {
    const std::uint16_t type = out.ring[i];
    return type >= 32 || ((format.returns_dropped >> type) & 1U) == 0;
  });
}

double value_at(const CloudView& cloud, int field, std::uint32_t offset) {
  const CloudField& which = cloud.fields[static_cast<std::size_t>(field)];
  return internal::with_type(which.type, [&](auto type) {
    return static_cast<double>(
        load<decltype(type)>(cloud.data.data() + offset + which.offset, cloud.big_endian));
  });
}

/// Median of the times of up to 65 points spread over the cloud, in units of the field: robust
/// against a few invalid ones. NaN if there is none.
double reference_time(const CloudView& cloud, int field, const Kept& kept) {
  std::array<double, 65> sample{};
  std::size_t count = 0;
  const std::size_t stride = std::max<std::size_t>(1, kept.count / 64);
  for (std::size_t i = 0; i < kept.count && count < sample.size(); i += stride) {
    const double value = value_at(cloud, field, kept.offsets[i]);
    if (std::isfinite(value)) sample[count++] = value;
  }
  if (count == 0) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = sample.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(sample.begin(), middle, sample.begin() + static_cast<std::ptrdiff_t>(count));
  return *middle;
}

bool absolute(PointTime time) {
  return time == PointTime::kAbsoluteS || time == PointTime::kAbsoluteNs;
}

/// Units of the time field to nanoseconds, exact if the field counts whole nanoseconds.
Duration to_duration(double value, double scale_s) {
  const double ns_per_unit = std::round(scale_s * 1e9);
  const double ns = value * ns_per_unit;
  if (!(std::abs(ns) < 9.0e18)) return Duration{};
  return Duration::from_ns(std::llround(ns));
}

/// First and last of the points' times in dt_s, and the index of the first.
struct Extremes {
  float first_s = 0.0F, last_s = 0.0F;
  std::size_t first = 0;

  [[nodiscard]] Duration span() const {
    return Duration::from_s(static_cast<double>(last_s - first_s));
  }
};

/// Shifts dt_s so that the earliest is 0; returns the times before the shift.
Extremes start_at_zero(LidarScan& out, std::size_t count) {
  Extremes times;
  times.first_s = times.last_s = out.dt_s[0];
  for (std::size_t i = 1; i < count; ++i) {
    times.first_s = std::min(times.first_s, out.dt_s[i]);
    times.last_s = std::max(times.last_s, out.dt_s[i]);
  }
  const auto begin = out.dt_s.begin();
  times.first = static_cast<std::size_t>(std::find(begin, out.dt_s.end(), times.first_s) - begin);
  for (std::size_t i = 0; i < count; ++i) out.dt_s[i] -= times.first_s;
  return times;
}

void times_from_field(const CloudView& cloud, const CloudFormat& format, Kept& kept,
                      LidarScan& out) {
  const double reference = reference_time(cloud, format.time, kept);
  const double window_s = 1.5 * std::max(format.scan_period_s, format.span_s);
  const bool relative = !absolute(format.point_time);
  // All times are invalid: 'relative' times that are days off have no reference.
  const bool lost = std::isnan(reference) ||
                    (relative && std::abs(reference * format.time_scale_s) > 2.0 * window_s);
  const double scale_s = format.time_scale_s;
  gather(cloud, format.time, kept, out.dt_s.data(), [&](auto value) {
    return static_cast<float>((static_cast<double>(value) - reference) * scale_s);
  });
  const auto window = static_cast<float>(window_s);
  std::size_t sane = 0;
  for (std::size_t i = 0; i < kept.count; ++i) sane += std::abs(out.dt_s[i]) <= window ? 1U : 0U;
  if (lost || sane != kept.count) {
    out.dropped_time = close_up(
        kept, out, [&](std::size_t i) { return !lost && std::abs(out.dt_s[i]) <= window; });
  }
  if (kept.count == 0) return;
  const Extremes times = start_at_zero(out, kept.count);
  // Read from the field again: a float of seconds would lose nanoseconds.
  const Duration first =
      to_duration(value_at(cloud, format.time, kept.offsets[times.first]), scale_s);
  if (relative) {
    out.t_start = cloud.stamp + first + Duration::from_s(format.time_shift_s);
  } else if (!format.anchor_to_header) {
    out.t_start = Time{} + first;
  } else if (format.header_stamp == HeaderStamp::kEnd) {
    out.t_start = cloud.stamp - times.span();
  } else {
    out.t_start = cloud.stamp;
  }
  out.t_end = out.t_start + times.span();
  out.has_point_times = true;
}

void times_from_azimuth(const CloudView& cloud, const CloudFormat& format, const Kept& kept,
                        LidarScan& out) {
  if (kept.count == 0) return;
  const auto start = static_cast<float>(format.azimuth_start_rad);
  const float turn = 2.0F * std::numbers::pi_v<float>;
  const float sign = format.azimuth_clockwise ? -1.0F : 1.0F;
  const auto period_s = static_cast<float>(format.scan_period_s);
  for (std::size_t i = 0; i < kept.count; ++i) {
    const float turned = sign * (std::atan2(out.y_m[i], out.x_m[i]) - start) / turn;
    float fraction = turned - std::floor(turned);
    if (fraction >= 1.0F) fraction = 0.0F;
    out.dt_s[i] = fraction * period_s;
  }
  const Extremes times = start_at_zero(out, kept.count);
  Time zero = cloud.stamp;
  if (format.header_stamp == HeaderStamp::kEnd) {
    zero = zero - Duration::from_s(format.scan_period_s);
  }
  out.t_start = zero + Duration::from_s(static_cast<double>(times.first_s));
  out.t_end = out.t_start + times.span();
  out.has_point_times = true;
}

void fill_times(const CloudView& cloud, const CloudFormat& format,
                const CloudFormatOptions& options, Kept& kept, LidarScan& out) {
  out.t_start = out.t_end = cloud.stamp;
  out.has_point_times = false;
  out.deskewed = options.deskewed;
  const bool azimuth = format.point_time == PointTime::kAzimuth;
  if (!options.deskewed && azimuth) return times_from_azimuth(cloud, format, kept, out);
  if (!options.deskewed && format.time >= 0) return times_from_field(cloud, format, kept, out);
  std::fill_n(out.dt_s.begin(), kept.count, 0.0F);
}

/// Nearest of the ascending elevations, by the tangent: avoids an arc tangent per point.
void rings_from_elevation(const CloudFormat& format, const Kept& kept, LidarScan& out) {
  std::vector<float> bounds;
  const std::vector<float>& rings_rad = format.ring_elevations_rad;
  bounds.reserve(rings_rad.size());
  for (std::size_t i = 0; i + 1 < rings_rad.size(); ++i) {
    bounds.push_back(std::tan(0.5F * (rings_rad[i] + rings_rad[i + 1])));
  }
  for (std::size_t i = 0; i < kept.count; ++i) {
    const float x = out.x_m[i], y = out.y_m[i];
    const float slope = out.z_m[i] / std::max(std::sqrt(x * x + y * y), 1e-9F);
    const auto above = std::upper_bound(bounds.begin(), bounds.end(), slope);
    out.ring[i] = static_cast<std::uint16_t>(above - bounds.begin());
  }
}

void fill_rings(const CloudView& cloud, const CloudLayout& layout, const CloudFormat& format,
                const Kept& kept, LidarScan& out) {
  out.has_rings = format.ring_from != RingFrom::kNone;
  out.rings = out.has_rings ? format.rings : std::uint16_t{0};
  const auto step = static_cast<std::uint32_t>(layout.point_stride);
  const auto row_step = static_cast<std::uint32_t>(layout.row_stride);
  const float last_ring = format.rings == 0 ? 0.0F : static_cast<float>(format.rings - 1);
  switch (format.ring_from) {
    case RingFrom::kField:
      gather(cloud, format.ring, kept, out.ring.data(), [&](auto value) {
        // Always below `rings`, because arrays per ring are indexed by it. False for NaN.
        const auto v = static_cast<float>(value);
        return v >= 0.0F ? static_cast<std::uint16_t>(std::min(v, last_ring)) : std::uint16_t{0};
      });
      break;
    case RingFrom::kElevation:
      rings_from_elevation(format, kept, out);
      break;
    case RingFrom::kRow:
    case RingFrom::kColumn:
      for (std::size_t i = 0; i < kept.count; ++i) {
        const std::uint32_t at = kept.offsets[i];
        const bool rows = format.ring_from == RingFrom::kRow;
        out.ring[i] = static_cast<std::uint16_t>(rows ? at / row_step : at % row_step / step);
      }
      break;
    case RingFrom::kNone:
      std::fill_n(out.ring.begin(), kept.count, std::uint16_t{0});
      break;
  }
}

void resize(LidarScan& out, std::size_t n) {
  for (std::vector<float>* v : {&out.x_m, &out.y_m, &out.z_m, &out.intensity, &out.dt_s}) {
    v->resize(n);
  }
  out.ring.resize(n);
}

bool usable(const CloudView& cloud, int field) {
  return field < 0 || (static_cast<std::size_t>(field) < cloud.fields.size() &&
                       internal::field_fits(cloud, cloud.fields[static_cast<std::size_t>(field)]));
}

Status check_format(const CloudView& cloud, const CloudFormat& format) {
  for (const int field : {format.x, format.y, format.z, format.intensity, format.ring, format.time,
                          format.return_type}) {
    if (!usable(cloud, field)) {
      return fail(ErrorCode::kInput, fmt::format("stamp {:.6f}", cloud.stamp.s()),
                  "a cloud has other fields than the first clouds of its topic",
                  "The cloud is left out.");
    }
  }
  if (format.x < 0 || format.y < 0 || format.z < 0 ||
      (format.ring_from == RingFrom::kField && format.ring < 0)) {
    return fail(ErrorCode::kInput, {}, "a cloud format without x, y, z");
  }
  return {};
}

}  // namespace

Status decode_cloud(const CloudView& cloud, const CloudFormat& format,
                    const CloudFormatOptions& options, LidarScan& out) {
  if (const Status status = check_format(cloud, format); !status) return status;
  const Result<CloudLayout> layout = internal::cloud_layout(cloud);
  if (!layout) return tl::make_unexpected(layout.error());
  // Offsets are 32 bits; no sensor sends 4 GiB per scan.
  if (cloud.data.size() > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::kInput, {}, "a cloud is larger than 4 GiB", "The cloud is left out.");
  }
  out.dropped_nan = out.dropped_range = out.dropped_time = out.dropped_return = 0;
  // Not clear(): growing a cleared vector would zero it again for each scan.
  resize(out, layout->points + 1);
  Kept kept;
  kept.offsets = std::make_unique_for_overwrite<std::uint32_t[]>(layout->points + 1);
  const Limits limits = internal::limits_of(options);
  if (layout->points > 0 && internal::packed_xyz(cloud, format)) {
    const PackedXyz xyz{cloud.fields[static_cast<std::size_t>(format.x)].offset};
    choose_points(cloud, *layout, xyz, limits, kept, out);
  } else if (layout->points > 0) {
    const AnyXyz xyz{{cloud.fields[static_cast<std::size_t>(format.x)],
                      cloud.fields[static_cast<std::size_t>(format.y)],
                      cloud.fields[static_cast<std::size_t>(format.z)]},
                     cloud.big_endian};
    choose_points(cloud, *layout, xyz, limits, kept, out);
  }
  drop_returns(cloud, format, kept, out);
  fill_times(cloud, format, options, kept, out);
  fill_rings(cloud, *layout, format, kept, out);
  if (format.intensity >= 0) {
    gather(cloud, format.intensity, kept, out.intensity.data(),
           [](auto value) { return static_cast<float>(value); });
  } else {
    std::fill_n(out.intensity.begin(), kept.count, 0.0F);
  }
  resize(out, kept.count);
  return {};
}

}  // namespace rali::wire
