#include "rali/cli/picture/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "rali/cli/picture/stroke_font.hpp"

namespace rali::cli {
namespace {

constexpr double kGapUnits = 1.5;    // between two characters
constexpr double kBlankUnits = 1.0;  // of a blank, besides the gap
constexpr double kPenUnits = 0.8;    // thickness of a stroke

struct Pixel {
  double x = 0.0, y = 0.0;
};

/// Smallest and largest pixel that a span with this reach can touch, cut to the sheet.
std::pair<int, int> span_of(double a, double b, double reach, std::uint32_t size) {
  const double last = static_cast<double>(size) - 1.0;
  const double from = std::clamp(std::floor(std::min(a, b) - reach), 0.0, last + 1.0);
  const double to = std::clamp(std::ceil(std::max(a, b) + reach), -1.0, last);
  return {static_cast<int>(from), static_cast<int>(to)};
}

double distance_to_segment(const Pixel& p, const Pixel& a, const Pixel& b) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  const double length2 = dx * dx + dy * dy;
  double share = 0.0;
  if (length2 > 0.0) {
    share = std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / length2, 0.0, 1.0);
  }
  return std::hypot(p.x - a.x - share * dx, p.y - a.y - share * dy);
}

std::uint8_t mixed(std::uint8_t under, std::uint8_t over, double share) {
  return static_cast<std::uint8_t>(std::lround(under + share * (over - under)));
}

/// Behind the first byte of a character beyond ASCII, which is drawn as one box.
bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

double glyph_units(char c) {
  if (c == ' ') return kBlankUnits;
  const std::string_view strokes = strokes_of(c);
  int widest = 0;
  for (std::size_t i = 0; i + 1 < strokes.size(); i += 3) {
    widest = std::max(widest, strokes[i] - '0');
  }
  return widest;
}

}  // namespace

Canvas::Canvas(std::uint32_t width, std::uint32_t height, Colour background) {
  image_.width = width;
  image_.height = height;
  image_.rgb.reserve(std::size_t{3} * width * height);
  for (std::size_t i = 0; i < std::size_t{width} * height; ++i) {
    image_.rgb.insert(image_.rgb.end(), {background.r, background.g, background.b});
  }
}

void Canvas::blend(int x, int y, Colour colour, double share) {
  if (x < 0 || y < 0 || std::cmp_greater_equal(x, image_.width) ||
      std::cmp_greater_equal(y, image_.height)) {
    return;
  }
  share = std::clamp(share, 0.0, 1.0);
  std::uint8_t* pixel = image_.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
  pixel[0] = mixed(pixel[0], colour.r, share);
  pixel[1] = mixed(pixel[1], colour.g, share);
  pixel[2] = mixed(pixel[2], colour.b, share);
}

void Canvas::rectangle(int x, int y, int width, int height, Colour colour) {
  for (int row = y; row < y + height; ++row) {
    for (int column = x; column < x + width; ++column) blend(column, row, colour, 1.0);
  }
}

void Canvas::line(double x0, double y0, double x1, double y1, double width, Colour colour) {
  if (!std::isfinite(x0 + y0 + x1 + y1 + width)) return;
  const double radius = 0.5 * width;
  const auto [left, right] = span_of(x0, x1, radius + 1.0, image_.width);
  const auto [top, bottom] = span_of(y0, y1, radius + 1.0, image_.height);
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const Pixel p{static_cast<double>(x), static_cast<double>(y)};
      const double covered = radius + 0.5 - distance_to_segment(p, {x0, y0}, {x1, y1});
      if (covered > 0.0) blend(x, y, colour, covered);
    }
  }
}

double Canvas::text(double x, double y, double height, std::string_view text, Colour colour) {
  const double unit = height / kCapitalUnits;
  for (const char c : text) {
    if (is_continuation(c)) continue;
    const std::string_view strokes = strokes_of(c);
    std::optional<Pixel> pen;
    for (std::size_t i = 0; i + 1 < strokes.size(); i += 3) {
      const Pixel next{x + unit * (strokes[i] - '0'),
                       y + unit * (strokes[i + 1] - '0' - kCapitalUnits)};
      if (pen) line(pen->x, pen->y, next.x, next.y, kPenUnits * unit, colour);
      const bool lifted = i + 2 < strokes.size() && strokes[i + 2] == '|';
      pen = lifted ? std::nullopt : std::optional<Pixel>(next);
    }
    x += unit * (glyph_units(c) + kGapUnits);
  }
  return x;
}

double Canvas::text_width(double height, std::string_view text) {
  double units = text.empty() ? 0.0 : -kGapUnits;
  for (const char c : text) {
    if (!is_continuation(c)) units += glyph_units(c) + kGapUnits;
  }
  return units * height / kCapitalUnits;
}

}  // namespace rali::cli
