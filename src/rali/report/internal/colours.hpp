#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace rali::report {

using Rgb = std::array<std::uint8_t, 3>;

/// Viridis at `fraction` (0 to 1): even steps of lightness, readable without colour vision.
/// Source: S. van der Walt, N. Smith, matplotlib colormaps (CC0), sampled at 16 places.
[[nodiscard]] Rgb viridis(double fraction);

/// The colours of the report's maps: a part of viridis that is visible on white paper.
/// @param reversed dark for 1 instead of for 0
[[nodiscard]] Rgb scale_colour(double fraction, bool reversed);

/// "#rrggbb".
[[nodiscard]] std::string css(const Rgb& colour);

/// Style of the i-th item of a drawing: both colour and dashes differ, so that one of the two
/// suffices.
struct Style {
  Rgb colour = {};
  std::string dash;  ///< stroke-dasharray; empty: solid line
};

[[nodiscard]] Style style_of(std::size_t i);

inline constexpr Rgb kTruthColour = {110, 116, 126};

}  // namespace rali::report
