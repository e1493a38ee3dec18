#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::map {

/// One keyframe as input of the map. The spans have equal length and are valid during the call
/// only.
struct KeyframeView {
  Time t;
  std::uint8_t vehicle = 0;
  geometry::SE3 T_map_body;
  geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< of geometry::boxplus
  geometry::SE3 T_body_lidar;                          ///< ray origin
  std::span<const float> x_m, y_m, z_m;                ///< in body, deskewed to t
  std::span<const float> intensity;                    ///< may be empty
  std::span<const std::uint16_t> ring;                 ///< may be empty
  /// Bodies of the fleet's other vehicles at t; may be empty.
  std::span<const geometry::Vec3> others_map_m;

  [[nodiscard]] std::size_t size() const { return x_m.size(); }

  [[nodiscard]] geometry::Vec3 point_body(std::size_t i) const {
    return {static_cast<double>(x_m[i]), static_cast<double>(y_m[i]), static_cast<double>(z_m[i])};
  }
};

/// True if lengths agree and the pose and its covariance are finite: only such may enter the map.
[[nodiscard]] bool is_usable(const KeyframeView& keyframe);

using KeyframeVisitor = std::function<void(const KeyframeView&)>;

/// Passes all keyframes to the visitor, one after the other, in the same order at each call: they
/// are on disk and need not fit into memory. Fails if a file cannot be read.
using KeyframeStream = std::function<Status(const KeyframeVisitor&)>;

}  // namespace rali::map
