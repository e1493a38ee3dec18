#include "rali/cli/picture/map_panel.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include <fmt/format.h>

#include "rali/cli/picture/colours.hpp"
#include "rali/cli/picture/height_layers.hpp"

namespace rali::cli {
namespace {

/// Spacing of the map's points, and the finest cell drawn.
constexpr double kSpacing_m = 0.05, kCellMin_m = 0.025;
/// Trajectory vertices closer than this to the previous one are omitted.
constexpr double kCornerStep_pt = 0.2;
constexpr double kSeam_pt = 0.45;
constexpr double kSmallText_pt = 6.0;

using Image = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

/// Cells of the whole panel, all strips side by side, with the pads around.
struct Cells {
  double cell_m = 1.0, left_m = 0.0, top_m = 0.0;
  int width = 1, height = 1;
};

Cells cells_of(const PanelView& view) {
  Cells cells;
  cells.cell_m = std::max(kDotPt / view.pt_per_m, kCellMin_m);
  const double pad_m = kPanelPad_pt / view.pt_per_m;
  cells.left_m = view.right_m.low - pad_m;
  cells.top_m = view.up_m.high + pad_m;
  cells.width = static_cast<int>((view.right_m.size() + 2.0 * pad_m) / cells.cell_m) + 1;
  cells.height = static_cast<int>((view.up_m.size() + 2.0 * pad_m) / cells.cell_m) + 1;
  return cells;
}

HeightLayers layers_of(const MapPicture& picture, const PanelView& view, const Cells& cells,
                       const Extent& z_m) {
  HeightLayers layers(cells.width, cells.height, z_m.low, z_m.high);
  // If cells are finer than the spacing of the points, each point fills a square of that size.
  const int reach = static_cast<int>(std::ceil(kSpacing_m / cells.cell_m - 1e-9));
  for (std::size_t i = 0; i < picture.x_m.size(); ++i) {
    const auto [right_m, up_m] = view.right_up_m(picture.x_m[i], picture.y_m[i]);
    const double column = (right_m - cells.left_m) / cells.cell_m;
    const double row = (cells.top_m - up_m) / cells.cell_m;
    if (!(column >= 0.0 && row >= 0.0 && column < cells.width && row < cells.height)) continue;
    for (int dy = 0; dy < std::max(reach, 1); ++dy) {
      for (int dx = 0; dx < std::max(reach, 1); ++dx) {
        layers.add(static_cast<int>(column) + dx, static_cast<int>(row) + dy, picture.z_m[i]);
      }
    }
  }
  return layers;
}

/// The points as an image, transparent elsewhere.
Image image_of(const MapPicture& picture, const PanelView& view, const Cells& cells,
               const Extent& z_m) {
  const HeightLayers layers = layers_of(picture, view, cells, z_m);
  Image image(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, cells.width, cells.height),
              &cairo_surface_destroy);
  cairo_surface_flush(image.get());
  unsigned char* data = cairo_image_surface_get_data(image.get());
  if (data == nullptr) return image;  // cairo's status then reports the error
  const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(image.get()));
  for (int y = 0; y < cells.height; ++y) {
    for (int x = 0; x < cells.width; ++x) {
      const double strength = layers.strength(x, y);
      if (!(strength > 0.0)) continue;
      const Colour colour = height_colour(layers.fraction(x, y));
      const auto part = [&](double of) {
        return static_cast<std::uint32_t>(std::lround(of * strength));
      };
      const std::uint32_t argb =
          part(255.0) << 24 | part(colour.r) << 16 | part(colour.g) << 8 | part(colour.b);
      std::memcpy(data + static_cast<std::size_t>(y) * stride + 4 * static_cast<std::size_t>(x),
                  &argb, sizeof argb);
    }
  }
  cairo_surface_mark_dirty(image.get());
  return image;
}

/// Draws the line of a trajectory; NaN interrupts it. (x, y): the view's top left corner.
void trace(const PictureTrajectory& trajectory, const PanelView& view, double x, double y,
           Sheet& sheet) {
  bool open = false;
  double last_x = 0.0, last_y = 0.0;
  const auto& points = trajectory.points_map_m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      open = false;
      continue;
    }
    const auto [right_m, up_m] = view.right_up_m(points[i].x(), points[i].y());
    const double px = x + (right_m - view.right_m.low) * view.pt_per_m;
    const double py = y + (view.up_m.high - up_m) * view.pt_per_m;
    const bool near = std::hypot(px - last_x, py - last_y) < kCornerStep_pt;
    if (open && near && i + 1 < points.size()) continue;
    if (open) {
      cairo_line_to(sheet.cairo(), px, py);
    } else {
      cairo_move_to(sheet.cairo(), px, py);
      cairo_line_to(sheet.cairo(), px, py);
    }
    open = true;
    last_x = px;
    last_y = py;
  }
}

void draw_trajectory(const PictureTrajectory& trajectory, const PanelView& view, std::size_t number,
                     double x, double y, Sheet& sheet) {
  cairo_t* cairo = sheet.cairo();
  trace(trajectory, view, x, y, sheet);
  if (trajectory.truth) {
    sheet.set_colour(kTruthColour);
    cairo_set_line_width(cairo, kTruthWidth_pt);
    cairo_stroke(cairo);
    return;
  }
  // A white outline separates it from the points below.
  sheet.set_colour(kWhite);
  cairo_set_line_width(cairo, kTrajectoryWidth_pt + 2.0 * kSeam_pt);
  cairo_stroke_preserve(cairo);
  set_trajectory_style(number, sheet);
  cairo_stroke(cairo);
  cairo_set_dash(cairo, nullptr, 0, 0.0);
}

void draw_ends(const PictureTrajectory& trajectory, const PanelView& view, Colour colour, double x,
               double y, Sheet& sheet) {
  std::vector<geometry::Vec3> finite;
  for (const geometry::Vec3& p : trajectory.points_map_m) {
    if (p.allFinite()) finite.push_back(p);
  }
  if (finite.empty()) return;
  const auto at = [&](const geometry::Vec3& p) {
    const auto [right_m, up_m] = view.right_up_m(p.x(), p.y());
    return std::array{x + (right_m - view.right_m.low) * view.pt_per_m,
                      y + (view.up_m.high - up_m) * view.pt_per_m};
  };
  const auto [start_x, start_y] = at(finite.front());
  const auto [end_x, end_y] = at(finite.back());
  draw_start(start_x, start_y, colour, sheet);
  draw_end(end_x, end_y, colour, sheet);
}

/// All trajectories: first the ground truths, then the others, then their ends.
void draw_trajectories(const MapPicture& picture, const PanelView& view,
                       const LabelNumber& number_of, double x, double y, Sheet& sheet) {
  cairo_set_line_cap(sheet.cairo(), CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(sheet.cairo(), CAIRO_LINE_JOIN_ROUND);
  for (const bool truth : {true, false}) {
    for (const PictureTrajectory& trajectory : picture.trajectories) {
      if (trajectory.truth != truth) continue;
      draw_trajectory(trajectory, view, truth ? 0 : number_of(trajectory.label), x, y, sheet);
    }
  }
  for (const PictureTrajectory& trajectory : picture.trajectories) {
    if (trajectory.truth) continue;
    draw_ends(trajectory, view, trajectory_colour(number_of(trajectory.label)), x, y, sheet);
  }
}

}  // namespace

void set_trajectory_style(std::size_t i, Sheet& sheet) {
  constexpr std::array<double, 2> kDash = {3.0, 2.4};
  sheet.set_colour(trajectory_colour(i));
  cairo_set_line_width(sheet.cairo(), kTrajectoryWidth_pt);
  if (i >= kTrajectoryColours) cairo_set_dash(sheet.cairo(), kDash.data(), kDash.size(), 0.0);
}

void draw_start(double x, double y, Colour colour, Sheet& sheet) {
  constexpr double kRadius_pt = 2.4, kRing_pt = 1.1;
  cairo_new_path(sheet.cairo());
  cairo_arc(sheet.cairo(), x, y, kRadius_pt, 0.0, 2.0 * M_PI);
  sheet.set_colour(kWhite);
  cairo_fill_preserve(sheet.cairo());
  sheet.set_colour(colour);
  cairo_set_line_width(sheet.cairo(), kRing_pt);
  cairo_stroke(sheet.cairo());
}

void draw_end(double x, double y, Colour colour, Sheet& sheet) {
  constexpr double kSide_pt = 3.4, kEdge_pt = 0.6;
  cairo_rectangle(sheet.cairo(), x - 0.5 * kSide_pt, y - 0.5 * kSide_pt, kSide_pt, kSide_pt);
  sheet.set_colour(kWhite);
  cairo_set_line_width(sheet.cairo(), 2.0 * kEdge_pt);
  cairo_stroke_preserve(sheet.cairo());
  sheet.set_colour(colour);
  cairo_fill(sheet.cairo());
}

void draw_panel(const MapPicture& picture, const PanelView& view, const Extent& z_m,
                const LabelNumber& number_of, double x, double y, Sheet& sheet) {
  const Cells cells = cells_of(view);
  const Image image = image_of(picture, view, cells, z_m);
  const double cell_pt = cells.cell_m * view.pt_per_m;
  cairo_t* cairo = sheet.cairo();
  for (std::size_t k = 0; k < view.strips; ++k) {
    const double start_m = static_cast<double>(k) * view.strip_m();
    y += view.gap_pt();
    if (view.strips > 1) {
      sheet.text(x + kPanelPad_pt, y, kSmallText_pt,
                 fmt::format("{:.0f} to {:.0f} m", start_m, start_m + view.strip_m()), kGrey);
    }
    cairo_save(cairo);
    cairo_rectangle(cairo, x, y, view.width_pt(), view.strip_height_pt());
    cairo_clip(cairo);
    const double shift = start_m * view.pt_per_m;
    cairo_save(cairo);
    cairo_translate(cairo, x - shift, y);
    cairo_scale(cairo, cell_pt, cell_pt);
    cairo_set_source_surface(cairo, image.get(), 0.0, 0.0);
    cairo_pattern_set_filter(cairo_get_source(cairo), CAIRO_FILTER_NEAREST);
    cairo_paint(cairo);
    cairo_restore(cairo);
    draw_trajectories(picture, view, number_of, x + kPanelPad_pt - shift, y + kPanelPad_pt, sheet);
    cairo_restore(cairo);
    y += view.strip_height_pt();
  }
}

}  // namespace rali::cli
