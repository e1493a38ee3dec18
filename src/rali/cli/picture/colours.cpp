#include "rali/cli/picture/colours.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace rali::cli {

Colour height_colour(double fraction) {
  // A sequential scale from light green to dark blue; visible on white paper at 0.
  constexpr std::array<std::array<double, 3>, 5> kStops = {
      {{120, 205, 175}, {62, 166, 172}, {51, 122, 163}, {57, 78, 140}, {42, 34, 78}}};
  const double at =
      std::clamp(std::isfinite(fraction) ? fraction : 0.0, 0.0, 1.0) * (kStops.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double t = at - static_cast<double>(low);
  const auto channel = [&](std::size_t c) {
    return static_cast<std::uint8_t>(std::lround(std::lerp(kStops[low][c], kStops[low + 1][c], t)));
  };
  return {channel(0), channel(1), channel(2)};
}

Colour trajectory_colour(std::size_t i) {
  // Vermilion, black and sky blue of M. Okabe and K. Ito, Color Universal Design (2008); yellow,
  // wine and violet chosen to differ from them and from the grey of the ground truth with any
  // colour vision.
  constexpr std::array<Colour, kTrajectoryColours> kColours = {
      {{213, 94, 0}, {0, 0, 0}, {240, 200, 40}, {136, 34, 85}, {86, 180, 233}, {120, 40, 160}}};
  return kColours[i % kColours.size()];
}

}  // namespace rali::cli
