#pragma once

#include "rali/base/result.hpp"
#include "rali/drive/map_run.hpp"
#include "rali/drive/output/rounds_files.hpp"
#include "rali/drive/output/session_file.hpp"
#include "rali/drive/ranges/range_log.hpp"

namespace rali::drive {

/// Writes the fleet's joint work to session.mcap, all in the frame of the map and at its final
/// poses:
/// /map (PointCloud2: all keyframes up to then, thinned; field `vehicle`), ten to twenty times over
/// the run; /ranges (lines between the antennas, one second each; green used, red rejected, grey
/// not needed or a repeat); /frontiers at the end of each round; /loops (lines; green accepted, red
/// rejected) at the time of their detection. Errors: kMachine.
[[nodiscard]] Status show_fleet(const FleetRunView& fleet, const MapJob& job,
                                const fleet::FleetEstimate& estimate, const RangeLog& ranges,
                                const FleetRounds& rounds, SessionFile& session);

/// Writes rounds.csv and frontiers.csv (unless rounds are off), and the fleet into `session` if
/// there is one. Nothing for a single vehicle. Errors: kMachine.
/// @return the rounds
[[nodiscard]] Result<std::vector<fleet::RoundRow>> write_fleet_story(
    const FleetRunView& fleet, const MapJob& job, const fleet::FleetEstimate& estimate,
    const RangeLog& ranges, SessionFile* session, FindingList& findings);

}  // namespace rali::drive
