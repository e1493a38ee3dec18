#include "rali/cli/picture/legend.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/cli/picture/colours.hpp"

namespace rali::cli {
namespace {

constexpr double kRow_pt = 13.0;
constexpr double kSample_pt = 16.0, kMark_pt = 6.0, kGap_pt = 4.0, kItemGap_pt = 12.0;
constexpr double kAxis_pt = 10.0;
constexpr double kHeightBar_pt = 44.0, kHeightBarThick_pt = 5.0;
constexpr double kBarMax = 0.14;                // of the width of the sheet
constexpr double kMiddle_pt = 0.36 * kText_pt;  // of the letters above the baseline

}  // namespace

Legend::Legend(const std::vector<MapPicture>& panels, const Extent& z_m) : z_m_(z_m) {
  bool truth = false;
  for (const MapPicture& panel : panels) {
    for (const PictureTrajectory& trajectory : panel.trajectories) {
      truth = truth || trajectory.truth;
      const bool known =
          std::find(labels_.begin(), labels_.end(), trajectory.label) != labels_.end();
      if (!trajectory.truth && !known) labels_.push_back(trajectory.label);
    }
  }
  if (truth) items_.push_back({Kind::kTruth, "truth", 0});
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    items_.push_back({Kind::kTrajectory, labels_[i], i});
  }
  if (labels_.empty()) return;
  items_.push_back({Kind::kStart, "start", 0});
  items_.push_back({Kind::kEnd, "end", 0});
}

std::size_t Legend::number_of(const std::string& label) const {
  return static_cast<std::size_t>(std::find(labels_.begin(), labels_.end(), label) -
                                  labels_.begin());
}

void Legend::set_map(const PanelView& view, double width_pt) {
  turned_ = view.turned;
  bar_m_ = scale_bar_m(kBarMax * width_pt / view.pt_per_m);
  bar_pt_ = bar_m_ * view.pt_per_m;
}

std::string Legend::bar_text() const { return fmt::format("{:g} m", bar_m_); }

/// Position of the corner of the axes, from the left end of the row.
double Legend::axes_x(Sheet& measure) const {
  return bar_pt_ + kGap_pt + measure.text_width(kText_pt, bar_text()) + 10.0 +
         (turned_ ? kAxis_pt + 6.0 : 0.0);
}

std::string Legend::low_text() const { return fmt::format("height {:.1f} m", z_m_.low); }

std::string Legend::high_text() const { return fmt::format("{:.1f} m", z_m_.high); }

/// Width of the height bar with its texts.
double Legend::heights_pt(Sheet& measure) const {
  return measure.text_width(kText_pt, low_text() + high_text()) + kHeightBar_pt + 2.0 * kGap_pt;
}

/// Positions of the items: in the first row between scale bar and heights if all fit, else in
/// separate rows.
std::vector<Legend::Place> Legend::places(double width_pt, Sheet& measure) const {
  const auto text_width = [&](std::string_view part) { return measure.text_width(kText_pt, part); };
  std::vector<Place> out;
  double sum = -kItemGap_pt;
  for (const Item& item : items_) {
    const bool mark = item.kind == Kind::kStart || item.kind == Kind::kEnd;
    out.push_back({0.0, 0.0, 0.0, shortened(item.text, width_pt / 3.0, text_width)});
    out.back().width = (mark ? kMark_pt : kSample_pt) + kGap_pt + text_width(out.back().text);
    sum += out.back().width + kItemGap_pt;
  }
  const double left = axes_x(measure) + kAxis_pt + 2.0 * kItemGap_pt;
  const double right = width_pt - heights_pt(measure) - kItemGap_pt;
  const bool one_row = sum <= right - left;
  double x = one_row ? left + 0.5 * (right - left - sum) : 0.0;
  double y = one_row ? 0.0 : kRow_pt;
  for (Place& place : out) {
    if (!one_row && x > 0.0 && x + place.width > width_pt) {
      x = 0.0;
      y += kRow_pt;
    }
    place.x = x;
    place.y = y;
    x += place.width + kItemGap_pt;
  }
  return out;
}

double Legend::height_pt(double width_pt, Sheet& measure) const {
  double rows_pt = 0.0;
  for (const Place& place : places(width_pt, measure)) rows_pt = std::max(rows_pt, place.y);
  return rows_pt + kRow_pt;
}

void Legend::draw_scale(double x, double y, Sheet& sheet) const {
  const double middle = y - kMiddle_pt;
  cairo_set_line_cap(sheet.cairo(), CAIRO_LINE_CAP_BUTT);
  sheet.line(x, middle, x + bar_pt_, middle, 1.2, kInk);
  for (const double end : {x + 0.5, x + bar_pt_ - 0.5}) {
    sheet.line(end, middle - 2.5, end, middle + 2.5, 1.0, kInk);
  }
  sheet.text(x + bar_pt_ + kGap_pt, y, kText_pt, bar_text(), kInk);
}

/// Draws the map's axes as oriented on the sheet; (x, y): their corner.
void Legend::draw_axes(double x, double y, Sheet& sheet) const {
  const auto arrow = [&](double dx, double dy, std::string_view name) {
    const double tip_x = x + kAxis_pt * dx, tip_y = y + kAxis_pt * dy;
    sheet.line(x, y, tip_x, tip_y, 0.8, kInk);
    for (const double side : {-1.0, 1.0}) {
      sheet.line(tip_x, tip_y, tip_x - 2.5 * dx + 1.5 * side * dy,
                 tip_y - 2.5 * dy + 1.5 * side * dx, 0.8, kInk);
    }
    const double letter_x = dx > 0.0 ? tip_x + 1.5 : dx < 0.0 ? tip_x - 6.0 : tip_x + 2.5;
    sheet.text(letter_x, dy < 0.0 ? tip_y + 4.0 : tip_y + 1.5, kText_pt - 1.0, name, kInk);
  };
  arrow(turned_ ? -1.0 : 1.0, 0.0, turned_ ? "y" : "x");
  arrow(0.0, -1.0, turned_ ? "x" : "y");
}

void Legend::draw_heights(double right, double y, Sheet& sheet) const {
  const double high_x = right - sheet.text_width(kText_pt, high_text());
  const double bar_x = high_x - kGap_pt - kHeightBar_pt;
  sheet.text(high_x, y, kText_pt, high_text(), kInk);
  sheet.text(right - heights_pt(sheet), y, kText_pt, low_text(), kInk);
  cairo_pattern_t* colours = cairo_pattern_create_linear(bar_x, 0.0, bar_x + kHeightBar_pt, 0.0);
  constexpr int kStops = 16;
  for (int i = 0; i <= kStops; ++i) {
    const double at = static_cast<double>(i) / kStops;
    const Colour c = height_colour(at);
    cairo_pattern_add_color_stop_rgb(colours, at, c.r / 255.0, c.g / 255.0, c.b / 255.0);
  }
  cairo_set_source(sheet.cairo(), colours);
  cairo_rectangle(sheet.cairo(), bar_x, y - kMiddle_pt - 0.5 * kHeightBarThick_pt, kHeightBar_pt,
                  kHeightBarThick_pt);
  cairo_fill(sheet.cairo());
  cairo_pattern_destroy(colours);
}

void Legend::draw_item(const Item& item, const Place& place, double x, double y,
                       Sheet& sheet) const {
  const double middle = y - kMiddle_pt;
  double text_x = x + kSample_pt + kGap_pt;
  cairo_set_line_cap(sheet.cairo(), CAIRO_LINE_CAP_BUTT);
  if (item.kind == Kind::kTruth) {
    sheet.line(x, middle, x + kSample_pt, middle, kTruthWidth_pt, kTruthColour);
  } else if (item.kind == Kind::kTrajectory) {
    cairo_move_to(sheet.cairo(), x, middle);
    cairo_line_to(sheet.cairo(), x + kSample_pt, middle);
    set_trajectory_style(item.number, sheet);
    cairo_stroke(sheet.cairo());
    cairo_set_dash(sheet.cairo(), nullptr, 0, 0.0);
  } else {
    text_x = x + kMark_pt + kGap_pt;
    const auto draw = item.kind == Kind::kStart ? draw_start : draw_end;
    draw(x + 0.5 * kMark_pt, middle, kInk, sheet);
  }
  sheet.text(text_x, y, kText_pt, place.text, kInk);
}

void Legend::draw(double x, double y, double width_pt, Sheet& sheet) const {
  const double base = y + kRow_pt - 4.0;
  draw_scale(x, base, sheet);
  draw_axes(x + axes_x(sheet), base + 1.5, sheet);
  draw_heights(x + width_pt, base, sheet);
  const std::vector<Place> at = places(width_pt, sheet);
  for (std::size_t i = 0; i < items_.size(); ++i) {
    draw_item(items_[i], at[i], x + at[i].x, base + at[i].y, sheet);
  }
}

}  // namespace rali::cli
