#include "rali/report/plot/map_raster.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "rali/io/files/png_writer.hpp"
#include "rali/report/internal/colours.hpp"

namespace rali::report {
namespace {

/// Colours times steps of strength, and white: what a palette holds.
constexpr std::size_t kColours = 30, kStrengths = 8;
constexpr std::size_t kSlices = 32;
constexpr double kWeakest = 0.22;

struct Pixel {
  std::uint32_t slices = 0;  ///< a bit for each slice of the depth that holds a point
  std::uint32_t count = 0;
  float sum = 0.0F;         ///< of values; of kinds: the leading one
  std::uint32_t known = 0;  ///< points with a value; of kinds: by how many it leads
};

/// Vote of R. Boyer and J. Moore (1981): who has more than half of all leads in the end.
void vote(double kind, Pixel& p) {
  if (p.known == 0) p.sum = static_cast<float>(kind);
  if (p.sum == static_cast<float>(kind)) {
    ++p.known;
  } else {
    --p.known;
  }
}

const std::vector<float>& axis_of(const MapPoints& map, std::size_t axis) {
  return axis == 0 ? map.x_m : axis == 1 ? map.y_m : map.z_m;
}

std::vector<std::array<std::uint8_t, 3>> palette(bool reversed, const std::vector<Rgb>& kinds) {
  std::vector<std::array<std::uint8_t, 3>> colours = {{255, 255, 255}};
  for (std::size_t c = 0; c <= kColours; ++c) {
    // The last one is for points without a value.
    const double place = static_cast<double>(c) / (kColours - 1);
    Rgb full = c == kColours ? Rgb{120, 120, 120} : scale_colour(place, reversed);
    if (c < kinds.size() && c < kColours) full = kinds[c];
    for (std::size_t s = 0; s < kStrengths; ++s) {
      const double alpha = kWeakest + (1.0 - kWeakest) * static_cast<double>(s) / (kStrengths - 1);
      Rgb mixed{};
      for (std::size_t k = 0; k < 3; ++k) {
        mixed[k] = static_cast<std::uint8_t>(std::lround(255.0 + alpha * (full[k] - 255.0)));
      }
      colours.push_back(mixed);
    }
  }
  return colours;
}

/// Slices that nearly all of the filled pixels stay below: the strongest colour.
std::uint32_t many_slices(const std::vector<Pixel>& pixels) {
  std::array<std::size_t, kSlices + 1> histogram{};
  std::size_t filled = 0;
  for (const Pixel& p : pixels) {
    if (p.count == 0) continue;
    ++histogram[static_cast<std::size_t>(std::popcount(p.slices))];
    ++filled;
  }
  std::size_t below = 0;
  for (std::size_t n = 1; n <= kSlices; ++n) {
    below += histogram[n];
    if (20 * below >= 18 * filled) return std::max<std::uint32_t>(static_cast<std::uint32_t>(n), 2);
  }
  return 2;
}

std::uint8_t index_of(const Pixel& p, std::uint32_t most, bool kinds) {
  if (p.count == 0) return 0;
  std::size_t colour = kColours;
  if (p.known > 0) {
    const double share = std::clamp(static_cast<double>(p.sum) / p.known, 0.0, 1.0);
    colour = kinds ? static_cast<std::size_t>(p.sum)
                   : static_cast<std::size_t>(std::lround(share * (kColours - 1)));
  }
  const double height = (static_cast<double>(std::popcount(p.slices)) - 1.0) / (most - 1.0);
  const double strength = std::clamp(height, 0.0, 1.0) * (kStrengths - 1);
  return static_cast<std::uint8_t>(1 + colour * kStrengths +
                                   static_cast<std::size_t>(std::lround(strength)));
}

/// The value that `rank` of the others are not above. Reorders the values.
double ranked(std::vector<float>& values, std::size_t rank) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

}  // namespace

Range range_of_points(const MapPoints& map, std::size_t axis) {
  Range range;
  const std::vector<float>& values = axis_of(map, axis);
  std::vector<float> sample;
  const std::size_t stride = values.size() / 200'000 + 1;
  for (std::size_t i = 0; i < values.size(); i += stride) {
    if (std::isfinite(values[i])) sample.push_back(values[i]);
  }
  if (sample.empty()) return range;
  const std::size_t tail = sample.size() / 1000;
  range.add(ranked(sample, tail));
  range.add(ranked(sample, sample.size() - 1 - tail));
  return range;
}

std::vector<std::byte> draw_points(const MapPoints& map, const ViewAxes& axes, const Range& right,
                                   const Range& up, std::uint32_t width, std::uint32_t height,
                                   const PointShare& share, bool reversed,
                                   const std::vector<Rgb>& kinds) {
  std::vector<Pixel> pixels(std::size_t{width} * height);
  const std::vector<float>& a = axis_of(map, axes.right);
  const std::vector<float>& b = axis_of(map, axes.up);
  const std::vector<float>& c = axis_of(map, axes.depth);
  const Range depth = range_of_points(map, axes.depth).widened(0.0, 0.1);
  for (std::size_t i = 0; i < map.size(); ++i) {
    const double column = (static_cast<double>(a[i]) - right.low()) / right.width() * width;
    const double row = (up.high() - static_cast<double>(b[i])) / up.width() * height;
    const double slice = (static_cast<double>(c[i]) - depth.low()) / depth.width() * kSlices;
    // NaN fails every comparison.
    if (!(column >= 0.0 && column < width && row >= 0.0 && row < height)) continue;
    if (!(slice >= -1e6 && slice <= 1e6)) continue;
    Pixel& p = pixels[static_cast<std::size_t>(row) * width + static_cast<std::size_t>(column)];
    p.slices |= 1U << static_cast<unsigned>(std::clamp(slice, 0.0, kSlices - 1.0));
    ++p.count;
    const double value = share(i);
    if (!std::isfinite(value)) continue;
    if (!kinds.empty()) {
      vote(std::clamp(value, 0.0, kColours - 1.0), p);
      continue;
    }
    p.sum += static_cast<float>(std::clamp(value, 0.0, 1.0));
    ++p.known;
  }
  io::IndexedImage image;
  image.width = width;
  image.height = height;
  image.palette = palette(reversed, kinds);
  image.index.reserve(pixels.size());
  const std::uint32_t most = many_slices(pixels);
  for (const Pixel& p : pixels) image.index.push_back(index_of(p, most, !kinds.empty()));
  return io::png_bytes(image);
}

double ErrorScale::share(double sigma_m) const {
  if (!known || !std::isfinite(sigma_m)) return kUnknown;
  return std::clamp((sigma_m - low_m) / std::max(high_m - low_m, 1e-9), 0.0, 1.0);
}

ErrorScale error_scale(const MapPoints& map) {
  std::vector<float> sample;
  const std::size_t stride = map.size() / 200'000 + 1;
  for (std::size_t i = 0; i < map.size(); i += stride) {
    if (std::isfinite(map.sigma_m[i]) && map.sigma_m[i] > 0.0F) sample.push_back(map.sigma_m[i]);
  }
  ErrorScale scale;
  if (sample.empty()) return scale;
  const std::size_t tail = sample.size() / 50;
  scale.known = true;
  scale.low_m = ranked(sample, tail);
  scale.high_m = ranked(sample, sample.size() - 1 - tail);
  scale.high_m = std::max(scale.high_m, scale.low_m + 1e-3);
  return scale;
}

}  // namespace rali::report
