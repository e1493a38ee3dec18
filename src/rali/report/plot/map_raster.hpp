#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "rali/report/internal/colours.hpp"
#include "rali/report/plot/axis.hpp"
#include "rali/report/run_data.hpp"

namespace rali::report {

/// What a map is seen along: the two axes of the picture (0 x, 1 y, 2 z) and the third.
struct ViewAxes {
  std::size_t right = 0, up = 1, depth = 2;
};

/// Values for the points: which of the colours each gets (0 to 1; NaN: grey).
using PointShare = std::function<double(std::size_t)>;

/// Where the middle of a cloud lies: a few far points must not make the map small.
/// @param axis 0 x, 1 y, 2 z. @return 0.1 % to 99.9 % of the points' values.
[[nodiscard]] Range range_of_points(const MapPoints& map, std::size_t axis);

/// The cloud seen along one axis as a PNG (bytes), white where nothing is. What is high along the
/// depth (walls) is dark, what is flat to the viewer (floors) is faint; colour by `share`, dark for
/// 1 if `reversed`. With `kinds` (at most 30) the value is the number of a kind: each pixel has the
/// colour of the kind that most of its points are of, grey where none is.
[[nodiscard]] std::vector<std::byte> draw_points(const MapPoints& map, const ViewAxes& axes,
                                                 const Range& right, const Range& up,
                                                 std::uint32_t width, std::uint32_t height,
                                                 const PointShare& share, bool reversed,
                                                 const std::vector<Rgb>& kinds = {});

/// Expected error as share of the colours: 0 at the 2nd, 1 at the 98th percentile.
struct ErrorScale {
  double low_m = 0.0, high_m = 0.0;
  bool known = false;

  [[nodiscard]] double share(double sigma_m) const;
};

[[nodiscard]] ErrorScale error_scale(const MapPoints& map);

}  // namespace rali::report
