#include "rali/report/plot/svg_plot.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/plot/axis.hpp"

namespace rali::report {
namespace {

constexpr double kRight = 12.0, kBottom = 34.0, kLegendRow = 15.0, kRail = 15.0;
constexpr std::size_t kDotsMax = 3000;

/// The frame of the data in pixels and values.
struct Frame {
  Range x, y;
  double left = 0.0, right = 0.0, top = 0.0, bottom = 0.0;
  double rail = 0.0;  ///< height of the rail below the frame
  bool log_y = false;

  [[nodiscard]] double value(double y_value) const { return log_y ? std::log10(y_value) : y_value; }

  [[nodiscard]] double px(double value_x) const {
    return left + (value_x - x.low()) / x.width() * (right - left);
  }

  [[nodiscard]] double py(double value_y) const {
    const double share = (value(value_y) - y.low()) / y.width();
    return bottom - std::clamp(share, -0.02, 1.02) * (bottom - top);
  }
};

bool drawable(const Plot& plot, double x, double y) {
  return std::isfinite(x) && std::isfinite(y) && (!plot.log_y || y > 0.0);
}

Frame frame_of(const Plot& plot) {
  Frame f;
  f.log_y = plot.log_y;
  f.left = plot.left;
  f.rail = plot.rail_label.empty() ? 0.0 : kRail;
  Range x, y;
  for (const Series& s : plot.series) {
    for (std::size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i) {
      if (!drawable(plot, s.x[i], s.y[i])) continue;
      x.add(s.x[i]);
      y.add(f.value(s.y[i]));
    }
  }
  if (x.empty()) return f;
  for (const Mark& m : plot.marks) {
    if (drawable(plot, 0.0, m.y)) y.add(f.value(m.y));
  }
  if (plot.x_min) x.add(*plot.x_min);
  if (plot.x_max) x.add(*plot.x_max);
  const double size = std::max(std::abs(y.low()), std::abs(y.high()));
  f.x = x.widened(0.0, 1e-3);
  f.y = y.widened(0.06, std::max(1e-6, 1e-6 * size));
  if (plot.y_min || plot.y_max) {
    Range fixed_y;
    fixed_y.add(plot.y_min ? f.value(*plot.y_min) : f.y.low());
    fixed_y.add(plot.y_max ? f.value(*plot.y_max) : f.y.high());
    f.y = fixed_y.widened(0.0, 1e-6);
  }
  return f;
}

using Tick = std::pair<double, std::string>;

/// 1, 2, 5, 10, .. where few decades are seen, else powers of ten.
std::vector<Tick> log_ticks(const Range& y) {
  std::vector<Tick> ticks;
  const double stride = std::max(1.0, std::ceil(y.width() / 6.0));
  constexpr double kDecadesMax = 1000.0;
  if (!(y.width() < kDecadesMax)) return ticks;
  for (double e = std::floor(y.low() / stride) * stride; e <= y.high(); e += stride) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      if (factor > 1.0 && y.width() > 2.5) break;
      const double at = e + std::log10(factor);
      if (at < y.low() || at > y.high()) continue;
      ticks.emplace_back(at, fmt::format("{:g}", factor * std::pow(10.0, e)));
    }
  }
  return ticks;
}

std::vector<Tick> ticks_up(const Plot& plot, const Frame& f) {
  if (f.log_y) return log_ticks(f.y);
  std::vector<Tick> ticks;
  if (!plot.y_step) {
    // One tick gives no scale.
    std::size_t count = 4;
    while (count < 8 && ticks_of(f.y, count).size() < 3) ++count;
    const double step = tick_step(f.y.width(), count);
    for (const double at : ticks_of(f.y, count)) ticks.emplace_back(at, tick_text(at, step));
    return ticks;
  }
  for (double at = std::ceil(f.y.low() / *plot.y_step) * *plot.y_step;
       at <= f.y.high() && ticks.size() < 20; at += *plot.y_step) {
    ticks.emplace_back(at, tick_text(at, *plot.y_step));
  }
  return ticks;
}

void draw_axes(const Plot& plot, const Frame& f, std::string& out) {
  auto at = std::back_inserter(out);
  const double step_x = tick_step(f.x.width(), 8);
  for (const double tick : ticks_of(f.x, 8)) {
    fmt::format_to(at, "<path class=\"grid\" d=\"M{0:.1f} {1:.1f}V{2:.1f}\"/>", f.px(tick), f.top,
                   f.bottom);
    fmt::format_to(at, "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"mid\">{}</text>\n", f.px(tick),
                   f.bottom + f.rail + 13.0, tick_text(tick, step_x));
  }
  for (const auto& [tick, text] : ticks_up(plot, f)) {
    const double py = f.bottom - (tick - f.y.low()) / f.y.width() * (f.bottom - f.top);
    fmt::format_to(at, "<path class=\"grid\" d=\"M{:.1f} {:.1f}H{:.1f}\"/>", f.left, py, f.right);
    fmt::format_to(at, "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"end\">{}</text>\n", f.left - 5.0,
                   py + 3.5, text);
  }
  fmt::format_to(at, "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"mid axis\">{}</text>",
                 0.5 * (f.left + f.right), f.bottom + f.rail + 28.0, escaped(plot.x_label));
  fmt::format_to(at,
                 "<text transform=\"translate({:.1f} {:.1f}) rotate(-90)\" class=\"mid axis\">{}"
                 "</text>\n",
                 f.left - 46.0, 0.5 * (f.top + f.bottom), escaped(plot.y_label));
  if (f.rail == 0.0) return;
  fmt::format_to(at,
                 "<rect class=\"rail\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" "
                 "height=\"{:.1f}\"><title>{}</title></rect>\n",
                 f.left, f.bottom + 2.0, f.right - f.left, f.rail - 2.0, escaped(plot.rail_label));
}

void draw_stretches(const Plot& plot, const Frame& f, std::string& out) {
  for (const Stretch& s : plot.stretches) {
    const double a = f.px(std::clamp(s.begin, f.x.low(), f.x.high()));
    const double b = f.px(std::clamp(s.end, f.x.low(), f.x.high()));
    fmt::format_to(std::back_inserter(out),
                   "<rect class=\"blind\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" "
                   "height=\"{:.1f}\"><title>{}</title></rect>\n",
                   a, f.top, std::max(b - a, 1.0), f.bottom - f.top, escaped(s.label));
  }
}

std::string line_path(const Plot& plot, const Series& s, const Frame& f) {
  std::string path;
  bool pen_down = false;
  const auto columns = static_cast<std::size_t>(f.right - f.left);
  for (const std::size_t i : outline(s.y, columns)) {
    if (i >= s.x.size()) break;
    if (!drawable(plot, s.x[i], s.y[i])) {
      pen_down = false;
      continue;
    }
    fmt::format_to(std::back_inserter(path), "{}{:.1f} {:.1f}", pen_down ? 'L' : 'M', f.px(s.x[i]),
                   f.py(s.y[i]));
    pen_down = true;
  }
  return path;
}

std::string dots_path(const Plot& plot, const Series& s, const Frame& f) {
  std::string path;
  const std::size_t n = s.on_rail ? s.x.size() : std::min(s.x.size(), s.y.size());
  const std::size_t stride = n / kDotsMax + 1;
  for (std::size_t i = 0; i < n; i += stride) {
    const bool shown = s.on_rail ? std::isfinite(s.x[i]) : drawable(plot, s.x[i], s.y[i]);
    if (!shown || s.x[i] < f.x.low() || s.x[i] > f.x.high()) continue;
    const double y = s.on_rail ? f.bottom + 2.0 + 0.5 * (f.rail - 2.0) : f.py(s.y[i]);
    path += marker_path(s.marker, f.px(s.x[i]), y);
  }
  return path;
}

/// The area between a whole line and the foot of the frame.
void draw_area(const Plot& plot, const Series& s, const Frame& f, std::string& out) {
  std::string path;
  double last_x = 0.0;
  bool open = false;
  const auto close = [&] {
    if (open) fmt::format_to(std::back_inserter(path), "L{:.1f} {:.1f}Z", last_x, f.bottom);
    open = false;
  };
  for (const std::size_t i : outline(s.y, static_cast<std::size_t>(f.right - f.left))) {
    if (i >= s.x.size()) break;
    if (!drawable(plot, s.x[i], s.y[i])) {
      close();
      continue;
    }
    last_x = f.px(s.x[i]);
    if (!open) fmt::format_to(std::back_inserter(path), "M{:.1f} {:.1f}", last_x, f.bottom);
    open = true;
    fmt::format_to(std::back_inserter(path), "L{:.1f} {:.1f}", last_x, f.py(s.y[i]));
  }
  close();
  if (path.empty()) return;
  fmt::format_to(std::back_inserter(out), "<path class=\"area\" fill=\"{}\" d=\"{}\"/>\n",
                 css(s.style.colour), path);
}

void draw_one(const Plot& plot, const Series& s, const Frame& f, std::string& out) {
  const std::string path = s.dots ? dots_path(plot, s, f) : line_path(plot, s, f);
  if (path.empty()) return;
  if (s.filled) draw_area(plot, s, f, out);
  const std::string dash =
      s.style.dash.empty() || s.dots ? "" : fmt::format(" stroke-dasharray=\"{}\"", s.style.dash);
  const bool shape = s.dots && s.marker != Marker::kDot;
  // In the rail no value stands: the script that shows values must not read one there.
  const char* kind = s.on_rail ? "on-rail" : shape ? "s shape" : "s";
  fmt::format_to(std::back_inserter(out),
                 "<path class=\"{}\" data-label=\"{}\" stroke=\"{}\" stroke-width=\"{}\"{} "
                 "d=\"{}\"/>\n",
                 kind, escaped(s.label), css(s.style.colour), s.width, dash, path);
}

void draw_series(const Plot& plot, const Frame& f, std::string& out) {
  for (const Series& s : plot.series) draw_one(plot, s, f, out);
  for (const Mark& m : plot.marks) {
    fmt::format_to(std::back_inserter(out),
                   "<path class=\"mark\" d=\"M{0:.1f} {1:.1f}H{2:.1f}\"/><text x=\"{3:.1f}\" "
                   "y=\"{4:.1f}\" class=\"end\">{5}</text>\n",
                   f.left, f.py(m.y), f.right, f.right - 3.0, f.py(m.y) - 3.0, escaped(m.label));
  }
}

/// How a series looks, 24 pixels wide.
std::string key_shape(const Series& s) {
  const bool shape = s.dots && s.marker != Marker::kDot;
  const std::string path = !s.dots ? std::string("M0 0H24") : marker_path(s.marker, 12.0, 0.0);
  return fmt::format(
      "<path class=\"key{}\" d=\"{}\" stroke=\"{}\" stroke-width=\"{}\" "
      "stroke-dasharray=\"{}\"/>",
      shape ? " shape" : "", path, css(s.style.colour),
      shape    ? 1.4
      : s.dots ? 5.0
               : 2.0,
      s.dots ? "" : s.style.dash);
}

/// Legend above the frame; @return its height.
double draw_legend(const Plot& plot, std::string& out) {
  double x = plot.left, y = 12.0;
  auto at = std::back_inserter(out);
  if (!plot.title.empty()) {
    fmt::format_to(at, "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"title\">{}</text>", x, y,
                   escaped(plot.title));
    x += 7.8 * static_cast<double>(plot.title.size()) + 24.0;
  }
  const auto entry = [&](const std::string& label, const std::string& shape, double mark_width) {
    const double width = mark_width + 8.0 + 6.6 * static_cast<double>(label.size()) + 14.0;
    if (x + width > plot.width && x > plot.left) {
      x = plot.left;
      y += kLegendRow;
    }
    fmt::format_to(at,
                   "<g transform=\"translate({:.1f} {:.1f})\">{}<text x=\"{:.1f}\" y=\"4\">{}"
                   "</text></g>\n",
                   x, y - 4.0, shape, mark_width + 5.0, escaped(label));
    x += width;
  };
  std::set<std::string> named;
  for (const Series& s : plot.series) {
    // What stands in the frame and in the rail below it has one key.
    if (s.label.empty() || !plot.legend || !named.insert(s.label).second) continue;
    entry(s.label, key_shape(s), 24.0);
  }
  if (!plot.stretches.empty()) {
    entry("blind", "<rect class=\"blind\" y=\"-5\" width=\"18\" height=\"10\"/>", 18.0);
  }
  return y + 6.0;
}

}  // namespace

std::vector<std::size_t> outline(const std::vector<double>& values, std::size_t columns) {
  std::vector<std::size_t> kept;
  const std::size_t n = values.size();
  if (n <= 2 * columns || columns == 0) {
    for (std::size_t i = 0; i < n; ++i) kept.push_back(i);
    return kept;
  }
  for (std::size_t c = 0; c < columns; ++c) {
    const std::size_t begin = c * n / columns, end = (c + 1) * n / columns;
    std::size_t low = begin, high = begin, broken = end;
    for (std::size_t i = begin; i < end; ++i) {
      if (!std::isfinite(values[i])) broken = i;
      if (values[i] < values[low] || !std::isfinite(values[low])) low = i;
      if (values[i] > values[high] || !std::isfinite(values[high])) high = i;
    }
    std::vector<std::size_t> column = {low, high};
    if (broken < end) column.push_back(broken);
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
    kept.insert(kept.end(), column.begin(), column.end());
  }
  return kept;
}

std::string svg_of(const Plot& plot) {
  Frame f = frame_of(plot);
  if (f.x.empty()) return {};
  std::string legend;
  f.top = draw_legend(plot, legend);
  f.right = plot.width - kRight;
  f.bottom = f.top + plot.height - kBottom;
  std::string out = fmt::format(
      "<svg class=\"plot\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\" "
      "data-scale='{{\"x0\":{},\"x1\":{},\"y0\":{},\"y1\":{},\"l\":{:.1f},\"r\":{:.1f},"
      "\"t\":{:.1f},\"b\":{:.1f},\"xu\":\"{}\",\"yu\":\"{}\",\"log\":{}}}'>\n",
      plot.width, f.bottom + f.rail + kBottom, escaped(plot.title + " " + plot.y_label), f.x.low(),
      f.x.high(), f.y.low(), f.y.high(), f.left, f.right, f.top, f.bottom, plot.x_unit, plot.y_unit,
      f.log_y);
  out += legend;
  fmt::format_to(std::back_inserter(out),
                 "<rect class=\"frame\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" "
                 "height=\"{:.1f}\"/>\n",
                 f.left, f.top, f.right - f.left, f.bottom - f.top);
  draw_axes(plot, f, out);
  draw_stretches(plot, f, out);
  draw_series(plot, f, out);
  return out + "</svg>\n";
}

}  // namespace rali::report
