#include "rali/report/plot/map_view.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"

namespace rali::report {
namespace {

constexpr double kLeft = 46.0, kRight = 10.0, kTop = 10.0, kBottom = 36.0, kBar = 44.0;
constexpr double kHeightMin = 110.0, kPixelsPerUnit = 1.6;
/// Shorter bars do not show how long they are, longer ones lead out of the picture.
constexpr double kBarShortest = 14.0, kBarLongest = 1e4;
constexpr std::size_t kWayPointsMax = 2500;
constexpr std::array<const char*, 3> kAxisNames = {"x", "y", "z"};

struct Frame {
  Range right, up;
  double left = kLeft, top = kTop, width = 0.0, height = 0.0;
  double stretch = 1.0;

  [[nodiscard]] double px(double v) const {
    return left + (v - right.low()) / right.width() * width;
  }

  [[nodiscard]] double py(double v) const { return top + (up.high() - v) / up.width() * height; }
};

double along(const geometry::Vec3& p, std::size_t axis) {
  return p[static_cast<Eigen::Index>(axis)];
}

Range range_of(const MapView& view, std::size_t axis) {
  Range range = view.map != nullptr ? range_of_points(*view.map, axis) : Range();
  for (const MapWay& way : view.ways) {
    for (const WayPoint& w : *way.points) range.add(along(w.p_m, axis));
  }
  return range;
}

/// Equal scale on both axes, as wide as the page or as high as allowed.
Frame frame_of(const MapView& view) {
  Frame f;
  f.right = range_of(view, view.axes.right).widened(0.02, 2.0);
  f.up = range_of(view, view.axes.up).widened(0.02, 1.0);
  f.width = view.width - kLeft - kRight;
  double scale = f.width / f.right.width();
  if (view.stretch_up && f.up.width() * scale < kHeightMin) {
    f.stretch = std::clamp(std::floor(kHeightMin / (f.up.width() * scale)), 1.0, 10.0);
  }
  if (f.up.width() * scale * f.stretch > view.height_max) {
    scale = view.height_max / (f.up.width() * f.stretch);
    f.right = f.right.widened(0.0, f.width / scale);
  }
  f.height = std::max(f.up.width() * scale * f.stretch, 60.0);
  f.up = f.up.widened(0.0, f.height / (scale * f.stretch));
  return f;
}

void draw_cloud(const MapView& view, const Frame& f, std::string& out) {
  if (view.map == nullptr || view.map->size() == 0) return;
  const auto width = static_cast<std::uint32_t>(f.width * kPixelsPerUnit);
  const auto height = static_cast<std::uint32_t>(f.height * kPixelsPerUnit);
  const PointShare share = view.share ? view.share : [](std::size_t) { return kUnknown; };
  const std::vector<std::byte> png = draw_points(*view.map, view.axes, f.right, f.up, width, height,
                                                 share, view.dark_is_high, view.kinds);
  fmt::format_to(std::back_inserter(out),
                 "<image x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" "
                 "href=\"data:image/png;base64,{}\"/>\n",
                 f.left, f.top, f.width, f.height, base64(png));
}

void draw_axes(const MapView& view, const Frame& f, std::string& out) {
  auto at = std::back_inserter(out);
  fmt::format_to(at,
                 "<rect class=\"frame\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" "
                 "height=\"{:.1f}\"/>\n",
                 f.left, f.top, f.width, f.height);
  const double step_x = tick_step(f.right.width(), 8);
  for (const double tick : ticks_of(f.right, 8)) {
    fmt::format_to(at,
                   "<path class=\"grid\" d=\"M{0:.1f} {1:.1f}v4\"/><text x=\"{0:.1f}\" "
                   "y=\"{2:.1f}\" class=\"mid\">{3}</text>\n",
                   f.px(tick), f.top + f.height, f.top + f.height + 15.0, tick_text(tick, step_x));
  }
  const std::size_t count = std::max<std::size_t>(3, static_cast<std::size_t>(f.height / 70.0));
  const double step_y = tick_step(f.up.width(), count);
  for (const double tick : ticks_of(f.up, count)) {
    fmt::format_to(at,
                   "<path class=\"grid\" d=\"M{0:.1f} {1:.1f}h-4\"/><text x=\"{2:.1f}\" "
                   "y=\"{3:.1f}\" class=\"end\">{4}</text>\n",
                   f.left, f.py(tick), f.left - 6.0, f.py(tick) + 3.5, tick_text(tick, step_y));
  }
  fmt::format_to(
      at,
      "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"mid axis\">{} of map [m]</text>"
      "<text transform=\"translate(11 {:.1f}) rotate(-90)\" class=\"mid axis\">{} [m]</text>\n",
      f.left + 0.5 * f.width, f.top + f.height + 30.0, kAxisNames[view.axes.right],
      f.top + 0.5 * f.height, kAxisNames[view.axes.up]);
  if (f.stretch > 1.0) {
    fmt::format_to(at,
                   "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"end axis\">heights are drawn {:.0f} "
                   "times as large</text>\n",
                   f.left + f.width, f.top + f.height + 30.0, f.stretch);
  }
}

/// A bar of a round length, about a sixth of the width, under the right end of the axis.
void draw_scale_bar(const Frame& f, std::string& out) {
  const double length = tick_step(f.right.width(), 6);
  const double width = length / f.right.width() * f.width;
  fmt::format_to(std::back_inserter(out),
                 "<g class=\"scale\" transform=\"translate({:.1f} {:.1f})\"><path d=\"M0 "
                 "-4v6H{:.1f}v-6\"/><text x=\"{:.1f}\" "
                 "y=\"-3\" class=\"mid\">{} m</text></g>\n",
                 f.left + f.width - width, f.top + f.height + 33.0, width, 0.5 * width,
                 tick_text(length, length));
}

std::string path_of(const MapView& view, const Frame& f, const std::vector<WayPoint>& way,
                    double begin_s, double end_s) {
  std::string path;
  const std::size_t stride = way.size() / kWayPointsMax + 1;
  double last_s = 0.0;
  for (std::size_t i = 0; i < way.size(); ++i) {
    if (i % stride != 0 && i + 1 != way.size()) continue;
    if (!(way[i].t_s >= begin_s && way[i].t_s <= end_s)) continue;
    // A stretch that was cut out is not bridged.
    const bool jump = path.empty() || way[i].t_s - last_s > 2.0 * static_cast<double>(stride);
    last_s = way[i].t_s;
    fmt::format_to(std::back_inserter(path), "{}{:.1f} {:.1f}", jump ? 'M' : 'L',
                   f.px(along(way[i].p_m, view.axes.right)), f.py(along(way[i].p_m, view.axes.up)));
  }
  return path;
}

void draw_way(const MapView& view, const Frame& f, const MapWay& way, std::string& out) {
  if (way.points->empty()) return;
  auto at = std::back_inserter(out);
  constexpr double kAll = 1e18;
  for (const MapStretch& stretch : way.blind) {
    const std::string path =
        path_of(view, f, *way.points, stretch.begin_s - 0.06, stretch.end_s + 0.06);
    if (path.empty()) continue;
    fmt::format_to(at, "<path class=\"blind-way {}\" d=\"{}\"><title>{}</title></path>\n",
                   stretch.css_class, path, escaped(stretch.label));
  }
  const std::string path = path_of(view, f, *way.points, -kAll, kAll);
  if (way.halo) {
    fmt::format_to(at, "<path class=\"halo\" d=\"{}\" stroke-width=\"{}\"/>", path,
                   way.width + 1.8);
  }
  fmt::format_to(at,
                 "<path class=\"s\" data-label=\"{}\" stroke=\"{}\" stroke-width=\"{}\" "
                 "stroke-dasharray=\"{}\" d=\"{}\"/>\n",
                 escaped(way.label), css(way.style.colour), way.width, way.style.dash, path);
}

/// Begin (ring) and end (square) of a vehicle's way with its name.
void draw_ends(const MapView& view, const Frame& f, const MapWay& way, std::string& out) {
  if (way.points->empty() || !way.ends) return;
  const auto at_pixel = [&](const WayPoint& w) {
    return std::pair(f.px(along(w.p_m, view.axes.right)), f.py(along(w.p_m, view.axes.up)));
  };
  const auto [bx, by] = at_pixel(way.points->front());
  const auto [ex, ey] = at_pixel(way.points->back());
  const std::string colour = css(way.style.colour);
  const bool at_border = ex > f.left + f.width - 60.0;
  fmt::format_to(std::back_inserter(out),
                 "<circle class=\"begin\" cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"4\" stroke=\"{2}\"/>"
                 "<rect class=\"end-mark\" x=\"{3:.1f}\" y=\"{4:.1f}\" width=\"8\" height=\"8\" "
                 "fill=\"{2}\"/><text x=\"{5:.1f}\" y=\"{6:.1f}\" class=\"name{8}\">{7}</text>\n",
                 bx, by, colour, ex - 4.0, ey - 4.0, at_border ? ex - 7.0 : ex + 7.0, ey - 6.0,
                 escaped(way.label), at_border ? " end" : "");
}

void draw_anchors(const MapView& view, const Frame& f, std::string& out) {
  for (const MapSpot& spot : view.anchors) {
    const double x = f.px(along(spot.p_m, view.axes.right));
    const double y = f.py(along(spot.p_m, view.axes.up));
    fmt::format_to(std::back_inserter(out),
                   "<path class=\"anchor\" d=\"M{:.1f} {:.1f}l6 10h-12z\"><title>{}</title></path>"
                   "\n",
                   x, y - 6.0, escaped(spot.label));
  }
}

void draw_frontiers(const MapView& view, const Frame& f, std::string& out) {
  for (const MapSpot& spot : view.frontiers) {
    const double x = f.px(along(spot.p_m, view.axes.right));
    const double y = f.py(along(spot.p_m, view.axes.up));
    if (!std::isfinite(x) || !std::isfinite(y)) continue;
    fmt::format_to(std::back_inserter(out),
                   "<path class=\"frontier\" d=\"M{:.1f} {:.1f}l5 5l-5 5l-5 -5z\"><title>{}</title>"
                   "</path>\n",
                   x, y - 5.0, escaped(spot.label));
  }
}

struct Pixel {
  double x = 0.0, y = 0.0;
};

Pixel pixel_of(const MapView& view, const Frame& f, const geometry::Vec3& p_m) {
  return {f.px(along(p_m, view.axes.right)), f.py(along(p_m, view.axes.up))};
}

void put_bar(const std::string& path, const MapBar& bar, std::string_view kind, std::string& out) {
  fmt::format_to(std::back_inserter(out),
                 "<path class=\"off-halo\" d=\"{0}\"/><path class=\"{2}\" d=\"{0}\"><title>{1}"
                 "</title></path>\n",
                 path, escaped(bar.label), kind);
}

/// A line of 2 sigma with a cap at each end.
void draw_bar(const MapView& view, const Frame& f, const MapBar& bar, std::string& out) {
  constexpr double kCap = 6.0;
  const Pixel a = pixel_of(view, f, bar.p_m - bar.half_m);
  const Pixel b = pixel_of(view, f, bar.p_m + bar.half_m);
  const double length = std::hypot(b.x - a.x, b.y - a.y);
  const double cx = -(b.y - a.y) / length * kCap, cy = (b.x - a.x) / length * kCap;
  put_bar(
      fmt::format(
          "M{:.1f} {:.1f}L{:.1f} {:.1f}M{:.1f} {:.1f}l{:.1f} {:.1f}M{:.1f} {:.1f}l{:.1f} {:.1f}",
          a.x, a.y, b.x, b.y, a.x - cx, a.y - cy, 2.0 * cx, 2.0 * cy, b.x - cx, b.y - cy, 2.0 * cx,
          2.0 * cy),
      bar, "off", out);
}

/// The axis alone: an arrow with two heads beside the way, a ring with a dot where the axis points
/// at the reader.
void draw_axis_arrow(const MapView& view, const Frame& f, const MapBar& bar, std::string& out) {
  constexpr double kHalf = 12.0, kHead = 4.5, kBeside = 13.0, kUpright = 0.3;
  const Pixel at = pixel_of(view, f, bar.p_m);
  const double right = along(bar.axis, view.axes.right), up = -along(bar.axis, view.axes.up);
  const double length = std::hypot(right, up);
  if (!(length > kUpright)) {
    put_bar(fmt::format("M{:.1f} {:.1f}m-5 0a5 5 0 1 0 10 0a5 5 0 1 0-10 0m5-1v2", at.x,
                        at.y - kBeside),
            bar, "axis-arrow", out);
    return;
  }
  const double ux = right / length, uy = up / length;
  // Above the way, or right of one that goes up.
  const double side = ux >= 0.0 ? 1.0 : -1.0;
  const double mx = at.x + side * uy * kBeside, my = at.y - side * ux * kBeside;
  std::string path = fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", mx - kHalf * ux, my - kHalf * uy,
                                 mx + kHalf * ux, my + kHalf * uy);
  for (const double end : {-1.0, 1.0}) {
    const double ex = mx + end * kHalf * ux, ey = my + end * kHalf * uy;
    const double bx = ex - end * kHead * ux, by = ey - end * kHead * uy;
    fmt::format_to(std::back_inserter(path), "M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}",
                   bx - 0.75 * kHead * uy, by + 0.75 * kHead * ux, ex, ey, bx + 0.75 * kHead * uy,
                   by - 0.75 * kHead * ux);
  }
  put_bar(path, bar, "axis-arrow", out);
}

/// How long a bar is in pixels.
double length_of(const MapView& view, const Frame& f, const MapBar& bar) {
  const Pixel a = pixel_of(view, f, bar.p_m - bar.half_m);
  const Pixel b = pixel_of(view, f, bar.p_m + bar.half_m);
  return std::hypot(b.x - a.x, b.y - a.y);
}

void draw_bars(const MapView& view, const Frame& f, std::string& out) {
  for (const MapBar& bar : view.bars) {
    const double length = length_of(view, f, bar);
    if (length > kBarShortest && length < kBarLongest) {
      draw_bar(view, f, bar, out);
    } else if (bar.axis.allFinite()) {
      draw_axis_arrow(view, f, bar, out);
    }
  }
}

void draw_colour_bar(const MapView& view, const Frame& f, double y, std::string& out) {
  auto at = std::back_inserter(out);
  constexpr std::size_t kSteps = 30;
  for (std::size_t i = 0; i < kSteps; ++i) {
    fmt::format_to(at, "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"6.4\" height=\"9\" fill=\"{}\"/>",
                   f.left + 6.0 * static_cast<double>(i), y,
                   css(scale_colour(static_cast<double>(i) / (kSteps - 1), view.dark_is_high)));
  }
  fmt::format_to(at,
                 "\n<text x=\"{0:.1f}\" y=\"{1:.1f}\">{2}</text><text x=\"{3:.1f}\" "
                 "y=\"{1:.1f}\" class=\"end\">{4}</text><text x=\"{5:.1f}\" y=\"{6:.1f}\" "
                 "class=\"axis\">{7}</text>\n",
                 f.left, y + 20.0, view.colour_low, f.left + 181.0, view.colour_high,
                 f.left + 192.0, y + 9.0, escaped(view.colour_text));
}

}  // namespace

BarsShown bars_shown(const MapView& view) {
  const Frame f = frame_of(view);
  BarsShown shown;
  for (const MapBar& bar : view.bars) {
    const double length = length_of(view, f, bar);
    (length > kBarShortest && length < kBarLongest ? shown.bars : shown.arrows) = true;
  }
  return shown;
}

std::string svg_of(const MapView& view) {
  if (range_of(view, view.axes.right).empty() || range_of(view, view.axes.up).empty()) return {};
  const Frame f = frame_of(view);
  const bool bar =
      view.share != nullptr && view.kinds.empty() && view.map != nullptr && view.map->size() > 0;
  const double height = f.top + f.height + kBottom + (bar ? kBar - 14.0 : 0.0);
  std::string out = fmt::format(
      "<svg class=\"plot map\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"map\" "
      "data-scale='{{\"both\":true,\"x0\":{},\"x1\":{},\"y0\":{},\"y1\":{},\"l\":{:.1f},"
      "\"r\":{:.1f},\"t\":{:.1f},\"b\":{:.1f},\"yn\":\"{}\"}}'>\n",
      view.width, height, f.right.low(), f.right.high(), f.up.low(), f.up.high(), f.left,
      f.left + f.width, f.top, f.top + f.height, kAxisNames[view.axes.up]);
  draw_cloud(view, f, out);
  draw_axes(view, f, out);
  for (const MapWay& way : view.ways) draw_way(view, f, way, out);
  draw_bars(view, f, out);
  draw_frontiers(view, f, out);
  draw_anchors(view, f, out);
  for (const MapWay& way : view.ways) draw_ends(view, f, way, out);
  if (!view.stretch_up) draw_scale_bar(f, out);  // a side view has no room; its axis is the same
  if (bar) draw_colour_bar(view, f, f.top + f.height + kBottom, out);
  return out + "</svg>\n";
}

}  // namespace rali::report
