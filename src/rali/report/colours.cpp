#include "rali/report/internal/colours.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace rali::report {
namespace {

constexpr std::array<Rgb, 16> kViridis = {{{68, 1, 84},
                                           {72, 26, 108},
                                           {71, 47, 125},
                                           {65, 68, 135},
                                           {57, 86, 140},
                                           {49, 104, 142},
                                           {42, 120, 142},
                                           {35, 136, 142},
                                           {31, 152, 139},
                                           {34, 168, 132},
                                           {53, 183, 121},
                                           {84, 197, 104},
                                           {122, 209, 81},
                                           {165, 219, 54},
                                           {210, 226, 27},
                                           {253, 231, 37}}};

/// Okabe and Ito, "Color Universal Design" (2008), without yellow and vermillion: yellow is not
/// visible on white, vermillion marks degenerate stretches.
constexpr std::array<Rgb, 6> kOkabeIto = {
    {{0, 114, 178}, {204, 121, 167}, {0, 158, 115}, {230, 159, 0}, {86, 180, 233}, {30, 30, 30}}};

/// Dots alone are reserved for the ground truth.
constexpr std::array<const char*, 5> kDashes = {"", "7 3", "10 2.5 2 2.5 2 2.5", "9 3 2 3", "14 4"};

}  // namespace

Rgb viridis(double fraction) {
  if (!(fraction > 0.0)) return kViridis.front();
  const double at = std::min(fraction, 1.0) * static_cast<double>(kViridis.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kViridis.size() - 2);
  const double part = at - static_cast<double>(i);
  Rgb colour{};
  for (std::size_t c = 0; c < 3; ++c) {
    colour[c] = static_cast<std::uint8_t>(
        std::lround((1.0 - part) * kViridis[i][c] + part * kViridis[i + 1][c]));
  }
  return colour;
}

Rgb scale_colour(double fraction, bool reversed) {
  constexpr double kLightest = 0.86;
  const double inside = std::clamp(fraction, 0.0, 1.0);
  return viridis(kLightest * (reversed ? 1.0 - inside : inside));
}

std::string css(const Rgb& colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

Style style_of(std::size_t i) {
  return {kOkabeIto[i % kOkabeIto.size()], kDashes[i % kDashes.size()]};
}

}  // namespace rali::report
