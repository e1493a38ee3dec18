#include "rali/cli/picture/map_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "rali/cli/picture/height_layers.hpp"

namespace rali::cli {
namespace {

constexpr Colour kWhite{255, 255, 255}, kInk{32, 36, 44}, kGrey{110, 116, 128};
constexpr Colour kStart{20, 140, 60}, kEnd{32, 36, 44};
constexpr double kLongSidePx = 1500.0, kShortSideMaxPx = 1100.0;
constexpr int kMarginPx = 60, kHeaderPx = 110, kFooterPx = 110;
constexpr double kTitlePx = 26.0, kTextPx = 15.0;
/// Share of the points beyond each edge of the picture: a few strays do not make the map small.
constexpr double kCut = 0.003;
/// Cells larger than the map's spacing have no holes.
constexpr double kPixelMin_m = 0.02, kSpacing_m = 0.05;

struct Range {
  double low = 0.0, high = 0.0;

  [[nodiscard]] double size() const { return high - low; }

  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }

  void include(const Range& other) {
    include(other.low);
    include(other.high);
  }
};

Range quantiles(std::span<const float> values, double cut) {
  std::vector<float> sorted;
  sorted.reserve(values.size());
  std::copy_if(values.begin(), values.end(), std::back_inserter(sorted),
               [](float v) { return std::isfinite(v); });
  if (sorted.empty()) return {};
  const auto at = [&](double share) {
    const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), sorted.begin() + k, sorted.end());
    return static_cast<double>(sorted[static_cast<std::size_t>(k)]);
  };
  return {at(cut), at(1.0 - cut)};
}

/// From metres of the map to pixels of the sheet.
class Frame {
 public:
  /// Of all pictures that are drawn at one scale.
  explicit Frame(std::span<const MapPicture> pictures) {
    x_ = quantiles(pictures.front().x_m, kCut);
    y_ = quantiles(pictures.front().y_m, kCut);
    for (const MapPicture& picture : pictures) {
      x_.include(quantiles(picture.x_m, kCut));
      y_.include(quantiles(picture.y_m, kCut));
      for (const PictureWay& way : picture.ways) {
        for (const geometry::Vec3& p : way.points_map_m) {
          x_.include(p.x());
          y_.include(p.y());
        }
      }
    }
    turned_ = y_.size() > x_.size();
    const double across_m = std::max(turned_ ? y_.size() : x_.size(), 1.0);
    const double up_m = std::max(turned_ ? x_.size() : y_.size(), 1.0);
    m_per_px_ = std::max({across_m / kLongSidePx, up_m / kShortSideMaxPx, kPixelMin_m});
    width_ = static_cast<int>(across_m / m_per_px_) + 1;
    height_ = static_cast<int>(up_m / m_per_px_) + 1;
  }

  [[nodiscard]] double m_per_px() const { return m_per_px_; }

  [[nodiscard]] int width() const { return width_; }

  [[nodiscard]] int height() const { return height_; }

  /// Pixels from the top left corner of the map's part of the sheet; a turn by 90 deg keeps left
  /// and right.
  [[nodiscard]] std::array<double, 2> pixel(double x_m, double y_m) const {
    if (turned_) return {(y_.high - y_m) / m_per_px_, (x_.high - x_m) / m_per_px_};
    return {(x_m - x_.low) / m_per_px_, (y_.high - y_m) / m_per_px_};
  }

 private:
  Range x_, y_;
  bool turned_ = false;
  double m_per_px_ = 1.0;
  int width_ = 1, height_ = 1;
};

void draw_points(const MapPicture& picture, const Frame& frame, const Range& z, int left, int top,
                 Canvas& canvas) {
  HeightLayers layers(frame.width(), frame.height(), z.low, z.high);
  // Below the spacing of the points, each fills a square of that size.
  const int reach = frame.m_per_px() < kSpacing_m ? 1 : 0;
  for (std::size_t i = 0; i < picture.x_m.size(); ++i) {
    const auto [px, py] = frame.pixel(picture.x_m[i], picture.y_m[i]);
    if (!(px >= 0.0 && py >= 0.0 && px < frame.width() && py < frame.height())) continue;
    for (int dy = 0; dy <= reach; ++dy) {
      for (int dx = 0; dx <= reach; ++dx) {
        layers.add(static_cast<int>(px) + dx, static_cast<int>(py) + dy, picture.z_m[i]);
      }
    }
  }
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      const double strength = layers.strength(x, y);
      if (strength > 0.0) {
        canvas.blend(left + x, top + y, height_colour(layers.share(x, y)), strength);
      }
    }
  }
}

void draw_way(const PictureWay& way, const Frame& frame, int left, int top, Canvas& canvas) {
  const auto at = [&](const geometry::Vec3& p) {
    const auto [x, y] = frame.pixel(p.x(), p.y());
    return std::array{x + left, y + top};
  };
  // A white seam sets the way off from the points under it.
  for (const bool seam : {true, false}) {
    for (std::size_t i = 1; i < way.points_map_m.size(); ++i) {
      const auto [x0, y0] = at(way.points_map_m[i - 1]);
      const auto [x1, y1] = at(way.points_map_m[i]);
      canvas.line(x0, y0, x1, y1, way.width_px + (seam ? 3.0 : 0.0), seam ? kWhite : way.colour);
    }
  }
}

void draw_ends(const PictureWay& way, const Frame& frame, int left, int top, Canvas& canvas) {
  if (way.points_map_m.empty()) return;
  const auto mark = [&](const geometry::Vec3& p, Colour colour) {
    const auto [x, y] = frame.pixel(p.x(), p.y());
    canvas.disc(x + left, y + top, 10.0, kWhite);
    canvas.disc(x + left, y + top, 7.5, colour);
  };
  mark(way.points_map_m.back(), kEnd);
  mark(way.points_map_m.front(), kStart);
}

void draw_scale_bar(const Frame& frame, int left, double y, Canvas& canvas) {
  const double length_m = scale_bar_m(240.0 * frame.m_per_px());
  const double length_px = length_m / frame.m_per_px();
  canvas.line(left, y, left + length_px, y, 3.0, kInk);
  for (const double x : {0.0, length_px}) {
    canvas.line(left + x, y - 7.0, left + x, y + 7.0, 3.0, kInk);
  }
  const std::string label = fmt::format("{:g} m", length_m);
  const double width = Canvas::text_width(kTextPx, label);
  canvas.text(left + 0.5 * (length_px - width), y - 16.0, kTextPx, label, kInk);
}

/// The bar of colours with the heights at its ends; it ends at `right`.
void draw_height_bar(const Range& z, int right, int y, Canvas& canvas) {
  constexpr int kLength = 240, kThick = 14;
  for (int i = 0; i < kLength; ++i) {
    canvas.rectangle(right - kLength + i, y - kThick / 2, 1, kThick,
                     height_colour(static_cast<double>(i) / kLength));
  }
  const std::string high = fmt::format("{:.1f} m", z.high);
  canvas.text(right - kLength, y - 16.0, kTextPx, fmt::format("{:.1f}", z.low), kInk);
  canvas.text(right - Canvas::text_width(kTextPx, high), y - 16.0, kTextPx, high, kInk);
  const std::string_view name = "height";
  canvas.text(right - 0.5 * (kLength + Canvas::text_width(kTextPx, name)), y - 16.0, kTextPx, name,
              kGrey);
}

void draw_legend(const MapPicture& picture, double x, double y, Canvas& canvas) {
  const double middle = y - 0.5 * kTextPx;
  for (const PictureWay& way : picture.ways) {
    if (way.label.empty()) continue;
    canvas.line(x, middle, x + 34.0, middle, way.width_px, way.colour);
    x = canvas.text(x + 46.0, y, kTextPx, way.label, kInk) + 26.0;
  }
  if (picture.ways.empty()) return;
  canvas.disc(x, middle, 7.5, kStart);
  x = canvas.text(x + 16.0, y, kTextPx, "start", kInk) + 26.0;
  canvas.disc(x, middle, 7.5, kEnd);
  canvas.text(x + 16.0, y, kTextPx, "end", kInk);
}

}  // namespace

Colour height_colour(double share) {
  // Equal steps of lightness, dark enough for white paper at every height.
  constexpr std::array<std::array<double, 3>, 5> kStops = {
      {{36, 42, 120}, {22, 112, 160}, {20, 150, 110}, {205, 140, 20}, {196, 48, 40}}};
  const double at = std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0) * (kStops.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double t = at - static_cast<double>(low);
  const auto channel = [&](std::size_t c) {
    return static_cast<std::uint8_t>(
        std::lround(kStops[low][c] + t * (kStops[low + 1][c] - kStops[low][c])));
  };
  return {channel(0), channel(1), channel(2)};
}

double scale_bar_m(double most_m) {
  if (!(most_m > 0.0) || !std::isfinite(most_m)) return 1.0;
  const double power = std::pow(10.0, std::floor(std::log10(most_m)));
  for (const double step : {5.0, 2.0}) {
    if (step * power <= most_m) return step * power;
  }
  return power;
}

namespace {

bool has_points(const MapPicture& picture) {
  return !picture.x_m.empty() && picture.x_m.size() == picture.y_m.size() &&
         picture.x_m.size() == picture.z_m.size();
}

void draw_panel(const MapPicture& picture, const Frame& frame, const Range& z, int left, int top,
                Canvas& canvas) {
  draw_points(picture, frame, z, left, top, canvas);
  for (const PictureWay& way : picture.ways) draw_way(way, frame, left, top, canvas);
  for (const PictureWay& way : picture.ways) draw_ends(way, frame, left, top, canvas);
}

/// Heights of all panels, so that a colour means one height.
Range heights(std::span<const MapPicture> pictures) {
  Range z = quantiles(pictures.front().z_m, 0.005);
  for (const MapPicture& picture : pictures) z.include(quantiles(picture.z_m, 0.005));
  z.high = std::max(z.high, z.low + 0.1);
  return z;
}

/// Scale, legend and colours under the maps.
void draw_footer(const MapPicture& picture, const Frame& frame, const Range& z, int sheet_px, int y,
                 Canvas& canvas) {
  draw_scale_bar(frame, kMarginPx, y, canvas);
  draw_legend(picture, kMarginPx + 320.0, y + 0.5 * kTextPx, canvas);
  draw_height_bar(z, kMarginPx + sheet_px, y, canvas);
}

}  // namespace

Result<io::RgbImage> draw_maps(const std::string& title, const std::vector<MapPicture>& panels) {
  constexpr int kCaptionPx = 72;
  if (panels.empty() || panels.size() > kPanelsMost) {
    return fail(ErrorCode::kInput, title,
                fmt::format("{} maps; one sheet holds 1 to {}", panels.size(), kPanelsMost));
  }
  for (const MapPicture& panel : panels) {
    if (!has_points(panel)) return fail(ErrorCode::kInput, panel.title, "no points to draw");
  }
  const Frame frame(panels);
  const Range z = heights(panels);
  const int sheet_px = std::max(frame.width(), 900);
  const int step_px = frame.height() + kCaptionPx;
  const int maps_px = static_cast<int>(panels.size()) * step_px;
  Canvas canvas(static_cast<std::uint32_t>(sheet_px + 2 * kMarginPx),
                static_cast<std::uint32_t>(maps_px + kHeaderPx + kFooterPx), kWhite);
  const int left = kMarginPx + (sheet_px - frame.width()) / 2;
  int top = kHeaderPx - 20;
  for (const MapPicture& panel : panels) {
    const double end = canvas.text(kMarginPx, top + 24.0, 1.2 * kTextPx, panel.title, kInk);
    canvas.text(end + 24.0, top + 24.0, kTextPx, panel.subtitle, kGrey);
    draw_panel(panel, frame, z, left, top + kCaptionPx - 24, canvas);
    top += step_px;
  }
  canvas.text(kMarginPx, 56.0, kTitlePx, title, kInk);
  draw_footer(panels.front(), frame, z, sheet_px, top + 80, canvas);
  return canvas.image();
}

Result<io::RgbImage> draw_map(const MapPicture& picture) {
  if (!has_points(picture)) {
    return fail(ErrorCode::kInput, picture.title, "the map has no points to draw");
  }
  const std::span<const MapPicture> alone(&picture, 1);
  const Frame frame(alone);
  const Range z = heights(alone);
  const int sheet_px = std::max(frame.width(), 900);
  Canvas canvas(static_cast<std::uint32_t>(sheet_px + 2 * kMarginPx),
                static_cast<std::uint32_t>(frame.height() + kHeaderPx + kFooterPx), kWhite);
  draw_panel(picture, frame, z, kMarginPx + (sheet_px - frame.width()) / 2, kHeaderPx, canvas);
  canvas.text(kMarginPx, 56.0, kTitlePx, picture.title, kInk);
  canvas.text(kMarginPx, 88.0, kTextPx, picture.subtitle, kGrey);
  draw_footer(picture, frame, z, sheet_px, kHeaderPx + frame.height() + 70, canvas);
  return canvas.image();
}

}  // namespace rali::cli
