#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace rali::report {

using Rgb = std::array<std::uint8_t, 3>;

/// Viridis at `share` (0 to 1): even steps of lightness, readable without colour vision.
/// Source: S. van der Walt, N. Smith, matplotlib colormaps (CC0), sampled at 16 places.
[[nodiscard]] Rgb viridis(double share);

/// The colours of the report's maps: a part of viridis that is seen on white paper.
/// @param reversed dark for 1 instead of for 0
[[nodiscard]] Rgb scale_colour(double share, bool reversed);

/// "#rrggbb".
[[nodiscard]] std::string css(const Rgb& colour);

/// How the i-th thing of a drawing is told from the others: by colour and by dashes, so that one
/// of the two suffices.
struct Style {
  Rgb colour = {};
  std::string dash;  ///< stroke-dasharray; empty: whole line
};

[[nodiscard]] Style style_of(std::size_t i);

inline constexpr Rgb kTruthColour = {110, 116, 126};
inline constexpr Rgb kBlindColour = {213, 94, 0};

}  // namespace rali::report
