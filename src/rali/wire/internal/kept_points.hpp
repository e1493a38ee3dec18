#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>

#include "rali/wire/cloud_format.hpp"
#include "rali/wire/internal/cloud_layout.hpp"

// The inner loops of decode_cloud: selection of points, and one field of the kept points.
namespace rali::wire::internal {

using sensor::LidarScan;

/// The kept points: byte offset of each in the cloud's data, in order.
struct Kept {
  std::unique_ptr<std::uint32_t[]> offsets;
  std::size_t count = 0;
};

struct Limits {
  float range2_min_m2 = 0.0F, range2_max_m2 = 0.0F;
  bool has_box = false;
  std::array<float, 6> box_lidar_m{};
};

[[nodiscard]] inline Limits limits_of(const CloudFormatOptions& options) {
  Limits limits;
  const auto clamped = [](double value) {
    return static_cast<float>(std::clamp(value, 0.0, 1e18));  // the square must be finite as a
                                                              // float
  };
  const float nearest_m = clamped(options.range_m[0]), farthest_m = clamped(options.range_m[1]);
  // At least the smallest number, so that a point at exactly zero needs no test of its own.
  limits.range2_min_m2 = std::max(nearest_m * nearest_m, std::numeric_limits<float>::min());
  limits.range2_max_m2 = farthest_m * farthest_m;
  if (options.self_box_lidar_m) {
    limits.has_box = true;
    for (std::size_t i = 0; i < 6; ++i) {
      limits.box_lidar_m[i] = static_cast<float>((*options.self_box_lidar_m)[i]);
    }
  }
  return limits;
}

[[nodiscard]] inline bool within_box(const std::array<float, 6>& box, float x, float y, float z) {
  return x >= box[0] && x <= box[1] && y >= box[2] && y <= box[3] && z >= box[4] && z <= box[5];
}

/// x y z as three contiguous float32 of this machine's byte order: the usual case.
struct PackedXyz {
  std::size_t offset;

  void operator()(const std::byte* point, float& x, float& y, float& z) const {
    std::array<float, 3> xyz;
    std::memcpy(xyz.data(), point + offset, sizeof(xyz));
    x = xyz[0];
    y = xyz[1];
    z = xyz[2];
  }
};

/// Any types, any order.
struct AnyXyz {
  std::array<CloudField, 3> fields;
  bool big_endian;

  void operator()(const std::byte* point, float& x, float& y, float& z) const {
    x = one(fields[0], point);
    y = one(fields[1], point);
    z = one(fields[2], point);
  }

  [[nodiscard]] float one(const CloudField& field, const std::byte* point) const {
    return with_type(field.type, [&](auto type) {
      return static_cast<float>(load<decltype(type)>(point + field.offset, big_endian));
    });
  }
};

template <class Xyz>
void choose_points(const CloudView& cloud, const CloudLayout& layout, const Xyz& xyz,
                   const Limits& limits, Kept& kept, LidarScan& out) {
  std::size_t count = 0;
  std::uint32_t nans = 0;
  float* const px = out.x_m.data();
  float* const py = out.y_m.data();
  float* const pz = out.z_m.data();
  for (std::size_t row = 0; row < layout.rows; ++row) {
    std::size_t at = row * layout.row_stride;
    for (std::size_t column = 0; column < layout.columns; ++column, at += layout.point_stride) {
      float x, y, z;
      xyz(cloud.data.data() + at, x, y, z);
      const float range2_m2 = x * x + y * y + z * z;
      // Always written: the next kept point overwrites a dropped one. False for NaN.
      px[count] = x;
      py[count] = y;
      pz[count] = z;
      kept.offsets[count] = static_cast<std::uint32_t>(at);
      bool keep = range2_m2 >= limits.range2_min_m2 && range2_m2 <= limits.range2_max_m2;
      if (limits.has_box && keep) keep = !within_box(limits.box_lidar_m, x, y, z);
      nans += !keep && !(range2_m2 > 0.0F) ? 1U : 0U;
      count += keep ? 1U : 0U;
    }
  }
  kept.count = count;
  out.dropped_nan = nans;
  out.dropped_range = static_cast<std::uint32_t>(layout.points - count) - nans;
}

[[nodiscard]] inline bool packed_xyz(const CloudView& cloud, const CloudFormat& format) {
  const auto& fx = cloud.fields[static_cast<std::size_t>(format.x)];
  const auto& fy = cloud.fields[static_cast<std::size_t>(format.y)];
  const auto& fz = cloud.fields[static_cast<std::size_t>(format.z)];
  const bool floats = fx.type == FieldType::kFloat32 && fy.type == FieldType::kFloat32 &&
                      fz.type == FieldType::kFloat32;
  return floats && fy.offset == fx.offset + 4 && fz.offset == fx.offset + 8 &&
         cloud.big_endian == (std::endian::native == std::endian::big);
}

/// out[i] = convert(value of `field` at kept point i).
template <class Out, class Convert>
void gather(const CloudView& cloud, int field, const Kept& kept, Out* out, Convert convert) {
  if (kept.count == 0) return;  // an empty cloud has no bytes to point into
  const CloudField& which = cloud.fields[static_cast<std::size_t>(field)];
  const std::byte* const base = cloud.data.data() + which.offset;
  with_type(which.type, [&](auto type) {
    using T = decltype(type);
    const auto loop = [&](auto swapped) {
      for (std::size_t i = 0; i < kept.count; ++i) {
        T value;
        std::memcpy(&value, base + kept.offsets[i], sizeof(T));
        if constexpr (swapped.value) value = byte_swapped(value);
        out[i] = convert(value);
      }
    };
    if (cloud.big_endian == (std::endian::native == std::endian::big)) {
      loop(std::false_type{});
    } else {
      loop(std::true_type{});
    }
  });
}

/// Keeps the points for which keep(i), and compacts all arrays filled so far.
template <class Keep>
std::uint32_t close_up(Kept& kept, LidarScan& out, Keep keep) {
  std::size_t to = 0;
  for (std::size_t i = 0; i < kept.count; ++i) {
    if (!keep(i)) continue;
    kept.offsets[to] = kept.offsets[i];
    out.x_m[to] = out.x_m[i];
    out.y_m[to] = out.y_m[i];
    out.z_m[to] = out.z_m[i];
    out.dt_s[to] = out.dt_s[i];
    ++to;
  }
  const auto dropped = static_cast<std::uint32_t>(kept.count - to);
  kept.count = to;
  return dropped;
}

}  // namespace rali::wire::internal
