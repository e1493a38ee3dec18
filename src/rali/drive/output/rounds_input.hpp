#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/fleet/rounds/round_machine.hpp"
#include "rali/io/files/range_csv.hpp"
#include "rali/map/explore_settings.hpp"

namespace rali::drive {

/// Source of the rounds of a run; fleet.yaml `rounds`.
enum class RoundsFrom : std::uint8_t {
  kStands,  ///< auto: a vehicle at standstill is anchor
  kTable,   ///< a CSV of the user
  kOff
};

/// Settings and inputs of `rali map` about rounds.
struct RoundsJob {
  RoundsFrom from = RoundsFrom::kStands;
  std::vector<fleet::Stand> table;         ///< for kTable
  std::vector<sensor::RadioSample> radio;  ///< by time; may be empty
  FindingList findings;                    ///< about both files
  fleet::RoundSettings rounds;
  map::ExploreSettings grid;
  map::FrontierSettings frontiers;
};

/// Reads `anchor,start_s,end_s`; stamps as in ranges.csv. Other columns are ignored, so that a
/// rounds.csv of a run can be used. Errors: kInput with file and line (unreadable, a column
/// missing, an anchor that is no vehicle, no number, intervals that overlap or end before they
/// begin).
[[nodiscard]] Result<std::vector<fleet::Stand>> read_rounds_csv(const std::string& path,
                                                                const io::RadioNames& names);

/// The same from a text. @param name for messages
[[nodiscard]] Result<std::vector<fleet::Stand>> parse_rounds_csv(std::string text,
                                                                 const std::string& name,
                                                                 const io::RadioNames& names);

/// Reads radio.csv into `job`, by time, with findings about irregularities. Errors: kInput.
[[nodiscard]] Status read_radio(const std::string& path, const io::RadioNames& names,
                                RoundsJob& job);

}  // namespace rali::drive
