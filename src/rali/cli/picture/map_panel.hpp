#pragma once

#include <array>
#include <cstddef>
#include <functional>

#include "rali/cli/picture/layout.hpp"
#include "rali/cli/picture/map_picture.hpp"

namespace rali::cli {

/// Transform from metres of the map to points of a panel.
struct PanelView {
  bool turned = false;  ///< by 90 deg: x of the map points up, y to the left
  Extent right_m, up_m;
  double pt_per_m = 1.0;
  std::size_t strips = 1;

  /// Coordinates to the right and up [m].
  [[nodiscard]] std::array<double, 2> right_up_m(double x_m, double y_m) const {
    return turned ? std::array{-y_m, x_m} : std::array{x_m, y_m};
  }

  [[nodiscard]] double strip_m() const { return right_m.size() / static_cast<double>(strips); }

  [[nodiscard]] double width_pt() const { return strip_m() * pt_per_m + 2.0 * kPanelPad_pt; }

  [[nodiscard]] double strip_height_pt() const {
    return up_m.size() * pt_per_m + 2.0 * kPanelPad_pt;
  }

  /// Space above each strip.
  [[nodiscard]] double gap_pt() const { return strips > 1 ? kStripGap_pt : 0.0; }

  [[nodiscard]] double height_pt() const {
    return static_cast<double>(strips) * (gap_pt() + strip_height_pt());
  }
};

inline constexpr double kTruthWidth_pt = 3.4, kTrajectoryWidth_pt = 1.1;

/// Number of a trajectory's label in the legend, from 0: determines colour and dashes.
using LabelNumber = std::function<std::size_t(const std::string&)>;

/// The map with its trajectories; (x, y) is the top left corner.
/// @param z_m  heights of the first and the last colour
void draw_panel(const MapPicture& picture, const PanelView& view, const Extent& z_m,
                const LabelNumber& number_of, double x, double y, Sheet& sheet);

/// Sets colour and dashes of the i-th trajectory for subsequent drawing.
void set_trajectory_style(std::size_t i, Sheet& sheet);

/// Marks the start (a ring) and the end (a square) of a trajectory.
void draw_start(double x, double y, Colour colour, Sheet& sheet);
void draw_end(double x, double y, Colour colour, Sheet& sheet);

}  // namespace rali::cli
