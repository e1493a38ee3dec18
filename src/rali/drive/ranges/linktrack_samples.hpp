#pragma once

#include <map>
#include <vector>

#include "rali/drive/ranges/range_options.hpp"
#include "rali/sensor/range_sample.hpp"
#include "rali/wire/messages.hpp"

namespace rali::drive {

/// Appends the ranges of one frame. A radio in no list becomes a stranger, except the one that
/// wrote the frame: it belongs to `self`.
/// @param ids radio number to antenna  @param t when the ranges were measured
void append_linktrack(const wire::LinktrackFrame& frame, Time t,
                      const std::map<std::int64_t, io::RadioEnd>& ids, VehicleId self,
                      std::vector<sensor::RangeSample>& out);

}  // namespace rali::drive
