#pragma once

#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/drive/map_run.hpp"

namespace rali::drive {

/// A source of ranges.sources without a message in any recording.
[[nodiscard]] Finding no_topic_finding(const std::string& topic);

/// Warnings about the ranges of a run: a topic without ranges, ranges of which none was used and
/// why, ranges between vehicles without a common clock.
/// @param placing vehicles were placed relative to each other by ranges
[[nodiscard]] FindingList range_findings(const RangeTally& tally, const MapJob& job,
                                         const std::vector<InputReport>& reports, bool placing);

}  // namespace rali::drive
