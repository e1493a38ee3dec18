#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace rali::cli {

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  [[nodiscard]] double size() const { return high - low; }

  void include(double value);
  void include(const Extent& other);
};

/// Lowest and highest of the finite values without the fraction `cut` at either end; 0 to 0 if
/// there are none.
[[nodiscard]] Extent extent_of(const std::vector<float>& values, double cut);

inline constexpr double kPanelPad_pt = 5.0;   ///< around the map, for marks at its edge
inline constexpr double kPanelGap_pt = 14.0;  ///< between panels side by side
inline constexpr double kStripGap_pt = 9.0;   ///< between strips, with a line of small text
inline constexpr std::size_t kStripsMax = 12;

/// Sizes for the layout: all panels have one width, each its own height.
struct PanelSizes {
  double right_m = 1.0;
  std::vector<double> up_m;
  double around_pt = 20.0;  ///< of each row of panels: caption and gap
};

/// Arrangement of panels on a sheet. All have one scale; a map much longer than wide is cut into
/// strips of equal length, one below the other.
struct Layout {
  double pt_per_m = 1.0;
  std::size_t columns = 1, strips = 1;
};

/// The number of columns with the largest scale, on a sheet of this width and at most as high as
/// wide (0.75 times that for one row of panels). Maps thinner than 3 mm are cut into strips.
[[nodiscard]] Layout choose_layout(const PanelSizes& panels, double width_pt);

using TextWidth = std::function<double(std::string_view)>;

/// Lines of a text no wider than `width`; a longer word is cut with "...".
[[nodiscard]] std::vector<std::string> wrapped(std::string_view text, double width,
                                               const TextWidth& text_width);

/// The text, or as much of its start as fits with "..." appended.
[[nodiscard]] std::string shortened(std::string_view text, double width,
                                    const TextWidth& text_width);

/// Length of the scale bar: 1, 2 or 5 times a power of ten, the longest not above `max_m`.
[[nodiscard]] double scale_bar_m(double max_m);

}  // namespace rali::cli
