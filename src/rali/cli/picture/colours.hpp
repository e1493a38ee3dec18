#pragma once

#include <cstddef>

#include "rali/cli/picture/sheet.hpp"

namespace rali::cli {

inline constexpr Colour kWhite{255, 255, 255}, kInk{30, 32, 38}, kGrey{105, 110, 120};
inline constexpr Colour kTruthColour{150, 150, 150};

/// The colour of a height, 0 (lowest) to 1. Its lightness falls monotonically, so that it is
/// readable with any colour vision and in greyscale print; walls appear dark.
[[nodiscard]] Colour height_colour(double fraction);

/// The i-th trajectory differs from the others in colour, after kTrajectoryColours also in dashes.
[[nodiscard]] Colour trajectory_colour(std::size_t i);

inline constexpr std::size_t kTrajectoryColours = 6;

}  // namespace rali::cli
