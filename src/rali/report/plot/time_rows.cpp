#include "rali/report/plot/time_rows.hpp"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/plot/axis.hpp"

namespace rali::report {
namespace {

constexpr double kLeft = kRowsLeft, kWidth = kRowsWidth, kRight = 12.0, kRow = 24.0,
                 kBarHeight = 17.0;
constexpr std::size_t kLabelMax = 16;

/// Bytes of the first characters: no character is cut in two.
std::string_view first_characters(std::string_view text, std::size_t n) {
  std::size_t at = 0;
  for (std::size_t i = 0; at < text.size(); ++at) {
    const bool begins = (static_cast<unsigned char>(text[at]) & 0xC0U) != 0x80U;
    if (begins && i++ == n) break;
  }
  return text.substr(0, at);
}

std::string short_label(const std::string& label) {
  const std::string_view first = first_characters(label, kLabelMax);
  return escaped(first) + (first.size() < label.size() ? "\xE2\x80\xA6" : "");
}

std::string axis_svg(const Range& t, const RowAxis& axis, double width, double bottom) {
  std::string out;
  const double step = tick_step(t.width(), 8);
  for (const double tick : ticks_of(t, 8)) {
    const double x = kLeft + (tick - t.low()) / t.width() * width;
    fmt::format_to(std::back_inserter(out), "<path class=\"grid\" d=\"M{0:.1f} 4V{1:.1f}\"/>", x,
                   bottom);
    if (!axis.drawn) continue;
    fmt::format_to(std::back_inserter(out),
                   "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"mid\">{}</text>", x, bottom + 13.0,
                   tick_text(tick, step));
  }
  if (!axis.drawn) return out;
  return out + fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"mid axis\">{}</text>\n",
                           kLeft + 0.5 * width, bottom + 28.0, escaped(axis.label));
}

std::string bar_svg(const TimeBar& bar, const Range& t, double width, double top) {
  const double begin_s = std::max(bar.begin_s, t.low()), end_s = std::min(bar.end_s, t.high());
  if (!(end_s >= begin_s)) return {};
  const double x = kLeft + (begin_s - t.low()) / t.width() * width;
  const double w = std::max((end_s - begin_s) / t.width() * width, 1.0);
  std::string out = fmt::format(
      "<rect class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"><title>{}"
      "</title></rect>",
      bar.css_class, x, top + (1.0 - bar.high) * kBarHeight, w, (bar.high - bar.low) * kBarHeight,
      escaped(bar.title));
  if (!bar.text.empty() && w > 6.5 * static_cast<double>(bar.text.size()) + 6.0) {
    out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"mid on-dark\">{}</text>",
                       x + 0.5 * w, top + 12.5, escaped(bar.text));
  }
  return out;
}

}  // namespace

std::string svg_of(const std::vector<TimeRow>& rows, const RowAxis& axis,
                   const std::string& words) {
  Range t;
  t.add(0.0);
  t.add(axis.end);
  t = t.widened(0.0, 1e-3);
  const double width = kWidth - kLeft - kRight;
  const double bottom = 6.0 + kRow * static_cast<double>(rows.size());
  std::string out = fmt::format(
      "<svg class=\"plot rows\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\">\n",
      kWidth, bottom + (axis.drawn ? 34.0 : 0.0), escaped(words));
  out += axis_svg(t, axis, width, bottom);
  double y = 6.0;
  for (const TimeRow& row : rows) {
    fmt::format_to(std::back_inserter(out),
                   "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"end\">{}</text>", kLeft - 8.0, y + 14.5,
                   short_label(row.label));
    for (const TimeBar& bar : row.bars) out += bar_svg(bar, t, width, y + 2.0);
    out += '\n';
    y += kRow;
  }
  return out + "</svg>\n";
}

}  // namespace rali::report
