#include "rali/cli/picture/layout.hpp"

#include <algorithm>
#include <cmath>

namespace rali::cli {
namespace {

constexpr double kThin_pt = 8.0;  // of a map: 3 mm
constexpr double kHeightMaxOneRow = 0.75, kHeightMax = 1.0;

/// Height of the maps of all rows at 1 pt/m, without pads [m].
double rows_m(const std::vector<double>& up_m, std::size_t columns) {
  double sum_m = 0.0;
  for (std::size_t i = 0; i < up_m.size(); i += columns) {
    const std::size_t end = std::min(i + columns, up_m.size());
    sum_m += *std::max_element(up_m.begin() + static_cast<std::ptrdiff_t>(i),
                               up_m.begin() + static_cast<std::ptrdiff_t>(end));
  }
  return sum_m;
}

/// The largest scale with this number of columns and strips [pt/m].
double scale_of(const PanelSizes& panels, double width_pt, std::size_t columns,
                std::size_t strips) {
  const auto c = static_cast<double>(columns), s = static_cast<double>(strips);
  const std::size_t rows = (panels.up_m.size() + columns - 1) / columns;
  const double cell_pt = (width_pt - (c - 1.0) * kPanelGap_pt) / c - 2.0 * kPanelPad_pt;
  const double height_pt =
      width_pt * (rows == 1 && strips == 1 ? kHeightMaxOneRow : kHeightMax) -
      static_cast<double>(rows) * (panels.around_pt + s * (2.0 * kPanelPad_pt + kStripGap_pt));
  return std::min(cell_pt / (panels.right_m / s),
                  std::max(height_pt, 1.0) / (s * rows_m(panels.up_m, columns)));
}

}  // namespace

void Extent::include(double value) {
  low = std::min(low, value);
  high = std::max(high, value);
}

void Extent::include(const Extent& other) {
  include(other.low);
  include(other.high);
}

Extent extent_of(const std::vector<float>& values, double cut) {
  std::vector<float> sorted;
  sorted.reserve(values.size());
  std::copy_if(values.begin(), values.end(), std::back_inserter(sorted),
               [](float v) { return std::isfinite(v); });
  if (sorted.empty()) return {0.0, 0.0};
  const auto at = [&](double fraction) {
    const auto k = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), sorted.begin() + k, sorted.end());
    return static_cast<double>(sorted[static_cast<std::size_t>(k)]);
  };
  return {at(cut), at(1.0 - cut)};
}

Layout choose_layout(const PanelSizes& panels, double width_pt) {
  Layout best;
  best.pt_per_m = 0.0;
  for (std::size_t columns = 1; columns <= panels.up_m.size(); ++columns) {
    const double scale = scale_of(panels, width_pt, columns, 1);
    if (scale > best.pt_per_m) best = {scale, columns, 1};
  }
  const double thinnest_m = *std::min_element(panels.up_m.begin(), panels.up_m.end());
  for (std::size_t strips = 2; strips <= kStripsMax; ++strips) {
    if (best.columns > 1 || thinnest_m * best.pt_per_m >= kThin_pt) break;
    const double scale = scale_of(panels, width_pt, 1, strips);
    if (scale > best.pt_per_m) best = {scale, 1, strips};
  }
  return best;
}

std::string shortened(std::string_view text, double width, const TextWidth& text_width) {
  if (text_width(text) <= width) return std::string(text);
  while (!text.empty() && text_width(std::string(text) + "...") > width) {
    // Removes multi-byte characters as a whole: first the continuation bytes, then the first byte.
    while (text.size() > 1 && (static_cast<unsigned char>(text.back()) & 0xC0U) == 0x80U) {
      text.remove_suffix(1);
    }
    text.remove_suffix(1);
  }
  return std::string(text) + "...";
}

std::vector<std::string> wrapped(std::string_view text, double width, const TextWidth& text_width) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string word = shortened(text.substr(0, end), width, text_width);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (word.empty()) continue;
    if (!lines.empty() && text_width(lines.back() + ' ' + word) <= width) {
      lines.back() += ' ' + word;
    } else {
      lines.push_back(word);
    }
  }
  return lines;
}

double scale_bar_m(double max_m) {
  if (!(max_m > 0.0) || !std::isfinite(max_m)) return 1.0;
  const double power = std::pow(10.0, std::floor(std::log10(max_m)));
  for (const double step : {5.0, 2.0}) {
    if (step * power <= max_m) return step * power;
  }
  return power;
}

}  // namespace rali::cli
