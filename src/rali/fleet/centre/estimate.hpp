#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/time.hpp"
#include "rali/fleet/frames/decided_by.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::fleet {

/// A keyframe in the fleet's joint estimate.
struct KeyframePose {
  Time t;
  geometry::SE3 T_map_body;
  geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< of geometry::boxplus
};

/// Relation of a vehicle's frame to the fleet's map.
struct VehicleFrame {
  VehicleId vehicle;
  std::uint32_t epoch = 0;
  /// Index in FleetEstimate::groups. Vehicles of one group share one map; its frame is that of the
  /// group's first vehicle: origin and heading of its first pose, z up.
  std::size_t group = 0;
  geometry::SE3 T_map_odom;             ///< at the vehicle's first node
  double sigma_m = 0.0;                 ///< of its first position in the map, horizontal
  double sigma_rad = 0.0;               ///< of its heading
  std::optional<DecidedBy> decided_by;  ///< nothing: the group's first
  std::string waits_for;                ///< a sentence: what is missing to join it; empty: nothing
};

/// Result of comparing two keyframes that may show one place.
struct LoopVerdict {
  KeyframeId from, to;
  Time t_from, t_to;
  geometry::SE3 T_from_to;
  geometry::Mat6 information = geometry::Mat6::Zero();
  bool accepted = false;
  std::string reason;    ///< "accepted", "no_match:overlap", "ambiguous", "veto", "slid", ...
  double score = 0.0;    ///< fraction of points that agree
  double shift_m = 0.0;  ///< distance of the measurement from the expected pose
};

/// Constant error of the ranges of a pair of radios.
struct PairBias {
  VehicleId a, b;
  std::uint8_t antenna_a = 0, antenna_b = 0;
  double bias_m = 0.0, sigma_m = 0.0;
  std::size_t ranges = 0, used = 0;
  double residual_std_m = 0.0;  ///< of those used
};

/// A range as used in the estimate, for graph files.
struct UsedRange {
  Time t;
  KeyframeId a, b;       ///< the nearest keyframes
  double range_m = 0.0;  ///< between the antennas of their bodies at the keyframes, bias removed
  double sigma_m = 0.0;
};

/// A start pose measured by hand that contradicts all other measurements: it was left out.
struct RejectedStart {
  VehicleId relative_to, vehicle;
  double off_m = 0.0, off_rad = 0.0;  ///< from the estimated start pose
  /// Number of scan comparisons that contradict it, if its true start pose is unknown.
  int contradicted_by = 0;
};

/// One map of all vehicles that could be joined. A vehicle without a path is a group of its own.
struct FleetEstimate {
  std::vector<std::vector<VehicleId>> groups;  ///< largest first
  std::vector<VehicleFrame> frames;            ///< by vehicle
  std::map<KeyframeId, KeyframePose> keyframes;
  std::vector<LoopVerdict> loops;  ///< by time of the later keyframe
  std::vector<PairBias> biases;
  std::vector<UsedRange> ranges;
  std::vector<RejectedStart> rejected_starts;
};

}  // namespace rali::fleet
