#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace rali::report {

/// Shapes that are told apart without colour.
enum class Marker : std::uint8_t {
  kDot,
  kCross,
  kSquare,
  kTriangle,
  kDiamond,
  kPlus,
  kRing,
  kDash,
  kStake,
  kStar,
  kVee
};

/// The shape at a place in pixels, as a path to be stroked. It begins with "M<x> <y>h0", from which
/// the page's script reads the place back.
[[nodiscard]] std::string marker_path(Marker marker, double x, double y);

}  // namespace rali::report
