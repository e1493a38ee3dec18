#pragma once

#include <string>
#include <vector>

namespace rali::report {

/// A stretch of time (or of the way) in a row; `css_class` says how it is filled, `title` what it
/// means.
struct TimeBar {
  double begin_s = 0.0, end_s = 0.0;
  std::string css_class, title;
  std::string text;              ///< written into it where there is room
  double low = 0.0, high = 1.0;  ///< part of the row's height, from its foot
};

struct TimeRow {
  std::string label;
  std::vector<TimeBar> bars;
};

/// What the rows stand over.
struct RowAxis {
  double end = 0.0;  ///< from 0
  std::string label = "time [s]";
  bool drawn = true;  ///< false: a plot below has the numbers
};

/// Where the rows' axis begins and ends, for plots that stand below them.
inline constexpr double kRowsLeft = 110.0, kRowsWidth = 760.0;

/// One row per thing over a common axis; bars are drawn in their order.
/// @param words what the drawing shows, for who does not see it
[[nodiscard]] std::string svg_of(const std::vector<TimeRow>& rows, const RowAxis& axis,
                                 const std::string& words);

}  // namespace rali::report
