#pragma once

#include "rali/fleet/facts/facts.hpp"
#include "rali/wire/fleet/pack.hpp"

namespace rali::wire {

/// Points of a keyframe, `q1cm_zstd` (algorithms_fleet 11.3): steps of 1 cm, sorted along a
/// space-filling curve, differences, one plane per byte, zstd. Decoded points are within 5 mm per
/// axis, in the curve's order; intensities within 8 (at the top 15).
void write_point_block(BodyWriter& body, const fleet::KeyframePoints& points);
void read_point_block(BodyReader& body, fleet::KeyframePoints& points);

}  // namespace rali::wire
