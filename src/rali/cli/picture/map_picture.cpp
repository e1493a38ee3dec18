#include "rali/cli/picture/map_picture.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/cli/picture/colours.hpp"
#include "rali/cli/picture/layout.hpp"
#include "rali/cli/picture/legend.hpp"
#include "rali/cli/picture/map_panel.hpp"

namespace rali::cli {
namespace {

constexpr double kMargin_pt = 5.0, kLine_pt = 10.0;
/// Fraction of the points beyond each edge of the picture: a few outliers must not shrink the map.
constexpr double kCut = 0.003, kHeightCut = 0.005;

Extent extent_of_panel(const MapPicture& picture, int axis) {
  Extent extent = extent_of(axis == 0 ? picture.x_m : picture.y_m, kCut);
  for (const PictureTrajectory& trajectory : picture.trajectories) {
    for (const geometry::Vec3& p : trajectory.points_map_m) {
      if (p.allFinite()) extent.include(p[axis]);
    }
  }
  // A map of one point must have a nonzero size.
  const double missing_m = std::max(1.0 - extent.size(), 0.0);
  return {extent.low - 0.5 * missing_m, extent.high + 0.5 * missing_m};
}

/// One view for each panel: the same horizontal extent and scale, each its own height.
std::vector<PanelView> views_of(const std::vector<MapPicture>& panels) {
  std::vector<Extent> x, y;
  Extent all_x, all_y;
  for (const MapPicture& panel : panels) {
    all_x.include(x.emplace_back(extent_of_panel(panel, 0)));
    all_y.include(y.emplace_back(extent_of_panel(panel, 1)));
  }
  std::vector<PanelView> views(panels.size());
  for (std::size_t i = 0; i < panels.size(); ++i) {
    PanelView& view = views[i];
    view.turned = all_y.size() > all_x.size();
    view.right_m = view.turned ? Extent{-all_y.high, -all_y.low} : all_x;
    view.up_m = view.turned ? x[i] : y[i];
  }
  return views;
}

/// Range of heights of all panels, so that a colour has one meaning.
Extent heights_of(const std::vector<MapPicture>& panels) {
  Extent z;
  for (const MapPicture& panel : panels) z.include(extent_of(panel.z_m, kHeightCut));
  z.high = std::max(z.high, z.low + 0.1);
  return z;
}

/// Everything of a sheet before drawing.
struct Plan {
  Layout layout;
  std::vector<PanelView> views;
  std::vector<std::vector<std::string>> captions;  ///< lines
  double width_pt = 0.0;                           ///< between the margins
  double cell_pt = 0.0;                            ///< width of a panel
  std::vector<double> row_pt;                      ///< heights of the rows without captions
  std::vector<double> caption_pt;                  ///< of the rows
  double title_pt = 0.0, legend_pt = 0.0;
};

std::string letter(std::size_t panel) { return fmt::format("({}) ", char('a' + panel)); }

Plan plan_of(const std::vector<MapPicture>& panels, const SheetOptions& options, Legend& legend,
             Sheet& measure) {
  Plan plan;
  plan.width_pt = options.width_mm * kPointsPerMm - 2.0 * kMargin_pt;
  plan.views = views_of(panels);
  PanelSizes sizes;
  sizes.right_m = plan.views.front().right_m.size();
  sizes.around_pt = 3.0 * kLine_pt;
  for (const PanelView& view : plan.views) sizes.up_m.push_back(view.up_m.size());
  plan.layout = choose_layout(sizes, plan.width_pt);
  const auto columns = static_cast<double>(plan.layout.columns);
  plan.cell_pt = (plan.width_pt - (columns - 1.0) * kPanelGap_pt) / columns;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    plan.views[i].pt_per_m = plan.layout.pt_per_m;
    plan.views[i].strips = plan.layout.strips;
    const std::string text = panels.size() > 1 ? letter(i) + panels[i].caption : panels[i].caption;
    plan.captions.push_back(wrapped(text, plan.cell_pt, [&](std::string_view part) {
      return measure.text_width(kText_pt, part);
    }));
    const std::size_t row = i / plan.layout.columns;
    plan.row_pt.resize(row + 1);
    plan.caption_pt.resize(row + 1);
    plan.row_pt[row] = std::max(plan.row_pt[row], plan.views[i].height_pt());
    plan.caption_pt[row] = std::max(
        plan.caption_pt[row], static_cast<double>(plan.captions[i].size()) * kLine_pt + kLine_pt);
  }
  plan.title_pt = options.title.empty() ? 0.0 : 2.0 * kLine_pt;
  legend.set_map(plan.views.front(), plan.width_pt);
  plan.legend_pt = legend.height_pt(plan.width_pt, measure);
  return plan;
}

double height_of(const Plan& plan) {
  double height = 2.0 * kMargin_pt + plan.title_pt + plan.legend_pt;
  for (std::size_t r = 0; r < plan.row_pt.size(); ++r)
    height += plan.row_pt[r] + plan.caption_pt[r];
  return height;
}

/// Snaps to a dot of the PNG, so that cells of the map and dots coincide.
double on_dot(double pt) { return std::round(pt / kDotPt) * kDotPt; }

void draw_plan(const Plan& plan, const std::vector<MapPicture>& panels, const Extent& z_m,
               const Legend& legend, Sheet& sheet) {
  double y = kMargin_pt + plan.title_pt;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const std::size_t row = i / plan.layout.columns;
    if (i > 0 && i % plan.layout.columns == 0) y += plan.row_pt[row - 1] + plan.caption_pt[row - 1];
    const double cell_x =
        kMargin_pt + static_cast<double>(i % plan.layout.columns) * (plan.cell_pt + kPanelGap_pt);
    const double x = cell_x + 0.5 * (plan.cell_pt - plan.views[i].width_pt());
    draw_panel(
        panels[i], plan.views[i], z_m,
        [&](const std::string& label) { return legend.number_of(label); }, on_dot(x),
        on_dot(y + plan.row_pt[row] - plan.views[i].height_pt()), sheet);
    double line_y = y + plan.row_pt[row] + kLine_pt;
    for (const std::string& line : plan.captions[i]) {
      const double width = sheet.text_width(kText_pt, line);
      sheet.text(cell_x + 0.5 * (plan.cell_pt - width), line_y, kText_pt, line, kInk);
      line_y += kLine_pt;
    }
  }
  y += plan.row_pt.back() + plan.caption_pt.back();
  legend.draw(kMargin_pt, y, plan.width_pt, sheet);
}

Status check(const std::vector<MapPicture>& panels, const SheetOptions& options) {
  if (panels.empty() || panels.size() > kPanelsMax) {
    return fail(ErrorCode::kInput, "picture",
                fmt::format("{} maps; one sheet holds 1 to {}", panels.size(), kPanelsMax));
  }
  if (!(options.width_mm >= kWidthMin_mm && options.width_mm <= kWidthMax_mm)) {
    return fail(ErrorCode::kInput, "--width",
                fmt::format("{} mm; a sheet is {} to {} mm wide", options.width_mm, kWidthMin_mm,
                            kWidthMax_mm));
  }
  for (const MapPicture& panel : panels) {
    const std::size_t n = panel.x_m.size();
    if (n == 0 || panel.y_m.size() != n || panel.z_m.size() != n) {
      return fail(ErrorCode::kInput, panel.name, "the map has no points to draw");
    }
  }
  return {};
}

}  // namespace

Result<std::vector<std::byte>> draw_maps(const std::vector<MapPicture>& panels,
                                         const SheetOptions& options) {
  if (Status s = check(panels, options); !s) return tl::make_unexpected(s.error());
  Sheet measure(1.0, 1.0, PictureFormat::kPng);
  const Extent z_m = heights_of(panels);
  Legend legend(panels, z_m);
  const Plan plan = plan_of(panels, options, legend, measure);
  Sheet sheet(options.width_mm * kPointsPerMm, height_of(plan), options.format);
  if (!options.title.empty()) {
    const std::string title = shortened(options.title, plan.width_pt, [&](std::string_view part) {
      return measure.text_width(kTitle_pt, part, true);
    });
    sheet.text(kMargin_pt, kMargin_pt + kLine_pt, kTitle_pt, title, kInk, true);
  }
  draw_plan(plan, panels, z_m, legend, sheet);
  return sheet.finish();
}

}  // namespace rali::cli
