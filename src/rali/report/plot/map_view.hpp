#pragma once

#include <string>

#include "rali/report/internal/colours.hpp"
#include "rali/report/plot/map_raster.hpp"

namespace rali::report {

/// A stretch of a way that is marked.
struct MapStretch {
  double begin_s = 0.0, end_s = 0.0;
  std::string css_class, label;
};

/// A way on the map, cut where it is not known.
struct MapWay {
  std::string label;
  const std::vector<WayPoint>* points = nullptr;
  Style style;
  std::vector<MapStretch> blind;
  double width = 2.2;
  bool ends = true;  ///< begin, end and name are shown
  bool halo = true;  ///< a white border hides what lies below
};

/// A place with a word.
struct MapSpot {
  geometry::Vec3 p_m = geometry::Vec3::Zero();
  std::string label;
};

/// How far off a place may be along one axis, drawn at the scale of the map; where that is too
/// short to be seen, an arrow beside the way shows the axis.
struct MapBar {
  geometry::Vec3 p_m = geometry::Vec3::Zero();
  geometry::Vec3 axis = geometry::Vec3::Zero();    ///< unit
  geometry::Vec3 half_m = geometry::Vec3::Zero();  ///< 1 sigma along the axis
  std::string label;
};

/// One view of a map: cloud as a picture, ways, scale bar, axes.
struct MapView {
  const MapPoints* map = nullptr;
  ViewAxes axes;
  PointShare share;        ///< colour of the points; empty: all grey
  std::vector<Rgb> kinds;  ///< not empty: `share` is the number of a kind, and there is no bar
  bool dark_is_high = false;
  std::string colour_text;  ///< under the colour bar, with both ends: low, high
  std::string colour_low, colour_high;
  std::vector<MapWay> ways;
  std::vector<MapSpot> anchors;
  std::vector<MapSpot> frontiers;  ///< without z: not drawn from the side
  std::vector<MapBar> bars;
  double width = 760.0, height_max = 620.0;
  bool stretch_up = false;  ///< a side view of a long map is drawn higher than it is, and says so
};

/// Whether any bar is long enough to be seen at the scale of the map, and any is not.
struct BarsShown {
  bool bars = false, arrows = false;
};

[[nodiscard]] BarsShown bars_shown(const MapView& view);

/// Empty if there is neither a point nor a way.
[[nodiscard]] std::string svg_of(const MapView& view);

}  // namespace rali::report
