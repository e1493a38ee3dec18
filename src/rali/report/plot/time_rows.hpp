#pragma once

#include <string>
#include <vector>

namespace rali::report {

/// A stretch of time in a row; `css_class` says how it is filled, `title` what it means.
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

/// One row per thing over a common axis of time; bars are drawn in their order.
/// @param words what the drawing shows, for who does not see it
[[nodiscard]] std::string svg_of(const std::vector<TimeRow>& rows, double end_s,
                                 const std::string& words);

}  // namespace rali::report
