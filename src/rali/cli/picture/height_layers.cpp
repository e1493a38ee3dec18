#include "rali/cli/picture/height_layers.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace rali::cli {
namespace {

constexpr int kSlices = 64;
constexpr double kSliceMin_m = 0.1;
/// A floor with its noise, or a step, fills two slices; a ceiling above it adds two.
constexpr int kFlatSlices = 4;
constexpr int kWallSlices = 9;
constexpr double kFlatStrength = 0.22;

}  // namespace

HeightLayers::HeightLayers(int width, int height, double low_m, double high_m)
    : width_(width),
      height_(height),
      low_m_(low_m),
      range_m_(std::max(high_m - low_m, kSliceMin_m)),
      slice_m_(std::max(range_m_ / kSlices, kSliceMin_m)),
      slices_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

void HeightLayers::add(int x, int y, double z_m) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_ || !std::isfinite(z_m)) return;
  const double slice = std::clamp(std::floor((z_m - low_m_) / slice_m_), 0.0, kSlices - 1.0);
  slices_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
          static_cast<std::size_t>(x)] |= std::uint64_t{1} << static_cast<int>(slice);
}

std::uint64_t HeightLayers::slices(int x, int y) const {
  return slices_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                 static_cast<std::size_t>(x)];
}

double HeightLayers::strength(int x, int y) const {
  const int filled = std::popcount(slices(x, y));
  if (filled == 0) return 0.0;
  const double upright =
      std::clamp(static_cast<double>(filled - kFlatSlices) / (kWallSlices - kFlatSlices), 0.0, 1.0);
  return kFlatStrength + (1.0 - kFlatStrength) * upright;
}

double HeightLayers::fraction(int x, int y) const {
  const std::uint64_t filled = slices(x, y);
  if (filled == 0) return 0.0;
  const bool flat = std::popcount(filled) <= kFlatSlices;
  const int slice = flat ? std::countr_zero(filled) : kSlices - 1 - std::countl_zero(filled);
  return std::min((static_cast<double>(slice) + 0.5) * slice_m_ / range_m_, 1.0);
}

}  // namespace rali::cli
