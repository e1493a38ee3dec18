#pragma once

#include "rali/fleet/messages/messages.hpp"
#include "rali/wire/fleet/pack.hpp"

namespace rali::wire {

/// A table of poses: positions to 1 mm, rotations within 1e-4 rad, standard deviations within 3 %;
/// about 24 bytes a pose.
void write_table(BodyWriter& body, const fleet::Table& table);
void read_table(BodyReader& body, fleet::Table& table);

}  // namespace rali::wire
