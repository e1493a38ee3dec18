#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/cli/picture/canvas.hpp"
#include "rali/geometry/types.hpp"

namespace rali::cli {

/// A way on the picture.
struct PictureWay {
  std::string label;  ///< for the legend; empty: not in it
  Colour colour;
  double width_px = 4.0;
  std::vector<geometry::Vec3> points_map_m;
};

/// What a picture of a map shows.
struct MapPicture {
  std::string title, subtitle;
  std::vector<float> x_m, y_m, z_m;  ///< points in the map frame, z up
  std::vector<PictureWay> ways;      ///< later ones are drawn over earlier ones
};

/// Maps from above, one below the other at one scale and in one frame, each with its own title and
/// subtitle; as draw_map() else. Errors (kInput): nothing to draw, or more than `kPanelsMost`.
[[nodiscard]] Result<io::RgbImage> draw_maps(const std::string& title,
                                             const std::vector<MapPicture>& panels);

inline constexpr std::size_t kPanelsMost = 6;

/// The map from above on white, coloured by height, with ways, scale bar and legend. What has
/// upright extent is drawn strong, floors and ceilings pale, so that walls stand out indoors, too.
/// Three points in a thousand beyond each edge are left out. The longer side lies across.
/// Errors (kInput): nothing to draw.
[[nodiscard]] Result<io::RgbImage> draw_map(const MapPicture& picture);

/// The colours of heights: dark blue at 0 over green to orange-red at 1.
[[nodiscard]] Colour height_colour(double share);

/// Length of the scale bar: 1, 2 or 5 times a power of ten, the longest below `most_m`.
[[nodiscard]] double scale_bar_m(double most_m);

/// Reads map.ply (or map.pcd) and the trajectories of a folder that `rali map` has written; the
/// truth, too, where `rali evaluate` has judged it.
/// Errors: kInput, with the file.
[[nodiscard]] Result<MapPicture> picture_of_folder(const std::string& out_dir);

}  // namespace rali::cli
