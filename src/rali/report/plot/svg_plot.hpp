#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "rali/report/internal/colours.hpp"
#include "rali/report/plot/markers.hpp"

namespace rali::report {

/// One line or cloud of dots. NaN in y breaks the line.
struct Series {
  std::string label;
  std::vector<double> x, y;
  Style style;
  bool dots = false;
  double width = 1.5;
  Marker marker = Marker::kDot;  ///< of the dots
  bool on_rail = false;          ///< y is not known: the dots stand in a rail below the frame
  bool filled = false;           ///< the area below the line is tinted
};

/// A stretch of x that is hatched over the whole height.
struct Stretch {
  double begin = 0.0, end = 0.0;
  std::string label;
};

/// A horizontal line with a word.
struct Mark {
  double y = 0.0;
  std::string label;
};

struct Plot {
  std::string title;
  std::string x_label = "time [s]", y_label;
  std::string x_unit = "s", y_unit;
  std::vector<Series> series;
  std::vector<Stretch> stretches;
  std::vector<Mark> marks;
  std::optional<double> y_min, y_max;
  std::optional<double> x_min, x_max;
  std::optional<double> y_step;  ///< between ticks; else round numbers
  bool log_y = false;            ///< values of 0 and less are left out
  bool legend = true;            ///< false: the title says what the only series is
  std::string rail_label;        ///< what stands in the rail; empty: there is none
  double width = 760.0, height = 170.0;
  double left = 58.0;  ///< where the frame begins
};

/// The plot as SVG: axes, ticks, legend by colour and dashes. Long lines are thinned out to the
/// lowest and highest value of each column of pixels. Empty if no series has a finite value.
[[nodiscard]] std::string svg_of(const Plot& plot);

/// Indices that keep the outline of `values` when drawn `columns` wide.
[[nodiscard]] std::vector<std::size_t> outline(const std::vector<double>& values,
                                               std::size_t columns);

}  // namespace rali::report
