#pragma once

#include <vector>

#include "rali/base/finding.hpp"
#include "rali/drive/map_run.hpp"

namespace rali::drive {

/// What the user should know about the ranges of a run: a topic that brought none, ranges of which
/// not one was used and why, ranges between vehicles without a common clock.
[[nodiscard]] FindingList range_findings(const RangeTally& tally, const MapJob& job,
                                         const std::vector<InputReport>& reports);

}  // namespace rali::drive
