#pragma once

#include "mission.hpp"
#include "rali/fleet/centre/round_centre.hpp"

namespace rali::fleet_bench {

/// Inputs of the fleet mapper besides the facts.
struct JoinOptions {
  std::string name;                   ///< of the row
  bool starts = true;                 ///< start poses as measured by hand: 0.2 m, 3 deg
  bool common_clock = true;           ///< false: no ranges, as if recorded on other days
  bool by_rounds = false;             ///< also estimates at the end of each round
  std::vector<std::string> settings;  ///< key=value
};

/// One vehicle's result as written by `rali map`.
struct Path {
  geometry::SE3 T_map_odom;
  std::vector<drive::PoseRecord> poses;  ///< in odom, corrected
  std::vector<drive::KeyframeRecord> keyframes;
};

/// State of the estimate at the end of a round.
struct RoundMark {
  Time end;
  fleet::FleetEstimate estimate;
  double cpu_ms = 0.0;
  std::size_t nodes = 0, unknowns = 0;  ///< of the solution; of the separator prior
  bool whole = false;                   ///< all facts were solved again
};

/// One map of a mission.
struct Joined {
  fleet::FleetEstimate estimate;
  std::vector<Path> paths;  ///< by vehicle
  double cpu_ms = 0.0;      ///< of the fleet mapper
  std::vector<RoundMark> rounds;
};

/// Passes the received facts to the fleet mapper. Errors: settings, unreadable facts.
[[nodiscard]] Result<Joined> join(const Mission& mission, std::uint64_t seed,
                                  const JoinOptions& options);

}  // namespace rali::fleet_bench
