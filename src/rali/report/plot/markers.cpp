#include "rali/report/plot/markers.hpp"

#include <array>

#include <fmt/format.h>

namespace rali::report {
namespace {

/// From the middle of the shape, in the order of Marker.
constexpr std::array<const char*, 11> kShapes = {"",
                                                 "m-2.8-2.8l5.6 5.6m0-5.6l-5.6 5.6",
                                                 "m-2.4-2.4h4.8v4.8h-4.8z",
                                                 "m0-3.2l3 5.4h-6z",
                                                 "m0-3.4l3 3.4l-3 3.4l-3-3.4z",
                                                 "m-3.2 0h6.4m-3.2-3.2v6.4",
                                                 "m-2.6 0a2.6 2.6 0 1 0 5.2 0a2.6 2.6 0 1 0-5.2 0",
                                                 "m-3.2 0h6.4",
                                                 "m0-3.2v6.4",
                                                 "m-3 0h6m-4.5-2.6l3 5.2m0-5.2l-3 5.2",
                                                 "m-2.8-2.6l2.8 5.2l2.8-5.2"};

}  // namespace

std::string marker_path(Marker marker, double x, double y) {
  return fmt::format("M{:.1f} {:.1f}h0{}", x, y, kShapes[static_cast<std::size_t>(marker)]);
}

}  // namespace rali::report
