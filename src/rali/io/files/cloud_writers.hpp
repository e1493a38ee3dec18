#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "rali/base/result.hpp"

namespace rali::io {

/// Columns of (a part of) the map, all of one length.
struct MapColumns {
  std::span<const float> x_m, y_m, z_m;  ///< in map
  std::span<const float> intensity;
  std::span<const float> sigma_m;       ///< expected position error
  std::span<const std::uint16_t> seen;  ///< keyframes that observed the point
  std::span<const std::uint8_t> vehicle;

  [[nodiscard]] std::size_t size() const { return x_m.size(); }
};

/// Yields the map part by part, so that it need not be in memory as a whole: true and `out` filled,
/// or false at the end.
using MapParts = std::function<Result<bool>(MapColumns& out)>;

/// All of `columns` as one part.
[[nodiscard]] MapParts one_part(const MapColumns& columns);

/// map.pcd (product.md section 5): binary, `x y z intensity sigma` float32, `seen` uint16,
/// `vehicle` uint8. `points`: the sum of all parts; asserted.
[[nodiscard]] Status write_map_pcd(const std::string& path, std::uint64_t points,
                                   const MapParts& parts);

/// map.ply: binary little endian, `x y z intensity scalar_sigma scalar_seen scalar_vehicle`.
[[nodiscard]] Status write_map_ply(const std::string& path, std::uint64_t points,
                                   const MapParts& parts);

struct LasOptions {
  /// Added to all coordinates, e.g. the origin of the site [m].
  std::array<double, 3> shift_m = {0.0, 0.0, 0.0};
  /// LAS intensity is a 16-bit number: 65535 / the sensor's largest value.
  double intensity_scale = 1.0;
};

/// LasOptions::intensity_scale for these values: the largest value shows whether the sensor's range
/// ends at 1, 255 or 65535.
[[nodiscard]] double las_intensity_scale(std::span<const float> intensity);

/// map.las: LAS 1.4, point format 6, scale 0.001 m, offset near the first point, not compressed.
/// sigma is an extra dimension ("sigma", float32), vehicle + 1 the point source (0 means "none"
/// there), seen the user data (at most 255). Header without date: same input, same bytes.
/// Errors: kMachine; kInput for a point farther than 2147 km from the first or not finite.
[[nodiscard]] Status write_map_las(const std::string& path, std::uint64_t points,
                                   const MapParts& parts, const LasOptions& options = {});

/// Columns of a keyframe's cloud, deskewed, in body.
struct KeyframeColumns {
  std::span<const float> x_m, y_m, z_m;
  std::span<const float> intensity;
  std::span<const std::uint16_t> ring;  ///< empty: no rings, written as 0

  [[nodiscard]] std::size_t size() const { return x_m.size(); }
};

/// keyframes/<v>/<seq>.pcd: binary, `x y z intensity` float32, `ring` uint16.
[[nodiscard]] Status write_keyframe_pcd(const std::string& path, const KeyframeColumns& columns);

}  // namespace rali::io
