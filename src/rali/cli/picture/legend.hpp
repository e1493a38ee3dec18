#pragma once

#include <string>
#include <vector>

#include "rali/cli/picture/layout.hpp"
#include "rali/cli/picture/map_panel.hpp"
#include "rali/cli/picture/map_picture.hpp"

namespace rali::cli {

inline constexpr double kText_pt = 8.0, kTitle_pt = 10.0;

/// The area under the panels: scale bar and axes at the left, heights at the right. Between them,
/// or below if there is no room, the key of lines and marks.
class Legend {
 public:
  Legend(const std::vector<MapPicture>& panels, const Extent& z_m);

  /// Number of a label, in the order in which labels occur.
  [[nodiscard]] std::size_t number_of(const std::string& label) const;

  /// Sets scale and axes of the map; before anything is measured or drawn.
  void set_map(const PanelView& view, double width_pt);

  /// Position of an item of the legend.
  struct Place {
    double x = 0.0, y = 0.0;  ///< left end and baseline, from the left end of the first row
    double width = 0.0;
    std::string text;  ///< shortened if necessary
  };

  [[nodiscard]] std::vector<Place> places(double width_pt, Sheet& measure) const;

  [[nodiscard]] double height_pt(double width_pt, Sheet& measure) const;

  /// (x, y): the top left corner.
  void draw(double x, double y, double width_pt, Sheet& sheet) const;

 private:
  enum class Kind { kTruth, kTrajectory, kStart, kEnd };

  struct Item {
    Kind kind = Kind::kTrajectory;
    std::string text;
    std::size_t number = 0;
  };

  [[nodiscard]] std::string bar_text() const;
  [[nodiscard]] std::string low_text() const;
  [[nodiscard]] std::string high_text() const;
  [[nodiscard]] double axes_x(Sheet& measure) const;
  [[nodiscard]] double heights_pt(Sheet& measure) const;
  void draw_scale(double x, double y, Sheet& sheet) const;
  void draw_axes(double x, double y, Sheet& sheet) const;
  void draw_heights(double right, double y, Sheet& sheet) const;
  void draw_item(const Item& item, const Place& place, double x, double y, Sheet& sheet) const;

  std::vector<std::string> labels_;
  std::vector<Item> items_;
  Extent z_m_;
  bool turned_ = false;
  double bar_m_ = 1.0, bar_pt_ = 1.0;
};

}  // namespace rali::cli
