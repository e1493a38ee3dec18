#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/cli/picture/sheet.hpp"
#include "rali/geometry/types.hpp"

namespace rali::cli {

/// A trajectory on the picture.
struct PictureTrajectory {
  std::string label;   ///< for the legend; the same label has the same colour on all panels
  bool truth = false;  ///< drawn broad and grey under all others
  std::vector<geometry::Vec3> points_map_m;
};

/// Content of one panel.
struct MapPicture {
  std::string name;                  ///< source, for errors
  std::string caption;               ///< under the panel
  std::vector<float> x_m, y_m, z_m;  ///< points in the map frame, z up
  std::vector<PictureTrajectory> trajectories;
};

struct SheetOptions {
  std::string title;  ///< above all panels; empty: none
  double width_mm = 181.0;
  PictureFormat format = PictureFormat::kPng;
};

inline constexpr double kOneColumn_mm = 88.0, kTwoColumns_mm = 181.0;
inline constexpr double kWidthMin_mm = 60.0, kWidthMax_mm = 420.0;
inline constexpr std::size_t kPanelsMax = 6;

/// The image file of a picture for a paper: maps from above, coloured by height, with trajectories
/// and a caption each, all panels at one scale and in one frame. Below them are scale bar, axes,
/// legend and heights. Vertical structure is drawn strong, floors and ceilings pale, so that walls
/// are visible indoors too. The outermost 0.3 % of the points at each edge are left out. The longer
/// side is horizontal. Errors (kInput): a panel without points, no panel or more than kPanelsMax,
/// an invalid width; kMachine.
[[nodiscard]] Result<std::vector<std::byte>> draw_maps(const std::vector<MapPicture>& panels,
                                                       const SheetOptions& options);

/// Reads map.ply (or map.pcd) and the trajectories of a folder that `rali map` has written; the
/// ground truth too, if `rali evaluate` has run. The caption holds distance travelled and error.
/// Errors: kInput, with the file.
[[nodiscard]] Result<MapPicture> picture_of_folder(const std::string& out_dir);

}  // namespace rali::cli
