#pragma once

#include <limits>
#include <string>
#include <vector>

#include "join.hpp"
#include "rali/fleet/messages/kind.hpp"

namespace rali::fleet_bench {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Loops by outcome.
struct LoopCount {
  std::size_t accepted = 0, refused = 0;
  std::size_t wrong = 0;  ///< accepted with an error above 0.3 m or 3 deg in observable directions
};

/// Figures of one mission joined in one way. NaN where nothing can be measured.
struct Scores {
  std::string row, scene;
  std::uint64_t seed = 0;
  std::size_t vehicles = 0;
  std::size_t joined = 0;                     ///< vehicles in the largest group
  std::size_t wrong_joins = 0;                ///< of these, with an error above 0.5 m or 5 deg
  double ape_m = kNone, ape_max_m = kNone;    ///< largest group of two or more, one alignment
  double alone_m = kNone;                     ///< the worst vehicle, each with its own alignment
  double frame_m = kNone, frame_deg = kNone;  ///< the worst vehicle against the first of its group
  double nees6 = kNone, nees_median = kNone;  ///< keyframes in the frame of the group's first pose
  double fraction95 = kNone;
  LoopCount loops;
  double centre_s = 0.0;    ///< CPU time
  double vehicles_s = 0.0;  ///< CPU time of all vehicles' software
  double duration_s = 0.0;  ///< of the data
  double path_m = 0.0;      ///< of all vehicles
  double mb_per_min = 0.0;  ///< facts of the vehicle that sends most
  double mesh_m = kNone;    ///< mean distance of the merged map to the world
  double mesh_p95_m = kNone;
  fleet::TrafficCount traffic;         ///< of all vehicles
  std::vector<std::string> waits_for;  ///< reasons of the vehicles that are not joined
  std::vector<std::string> decided_by;
};

/// Errors (kNoAnswer): no poses.
[[nodiscard]] Result<Scores> score(const Mission& mission, const Joined& joined, const Place& place,
                                   const JoinOptions& options);

/// Every loop with its error, and every keyframe with its own, as CSV.
void dump(const std::string& dir, const Mission& mission, const Joined& joined,
          const Scores& scores);

}  // namespace rali::fleet_bench
