#pragma once

#include "rali/fleet/facts/facts.hpp"
#include "rali/wire/fleet/pack.hpp"

namespace rali::wire {

/// Ranges of one second with the poses at which they were measured: differences from the previous
/// entry, in steps of 0.1 mm and 2^-18 of a quaternion (fleet/facts/rounding.hpp); about 16 bytes a
/// range.
void write_range_block(BodyWriter& body, const fleet::RangeBlock& block);
void read_range_block(BodyReader& body, fleet::RangeBlock& block);

}  // namespace rali::wire
