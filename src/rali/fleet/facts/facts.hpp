#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/time.hpp"
#include "rali/fleet/facts/packed_points.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/graph/factors.hpp"

/// Permanent data that the vehicles of a fleet exchange (algorithms_fleet 11.1): immutable facts,
/// each of which enters one estimate once. All other messages between vehicles are soft state that
/// the next message replaces.
namespace rali::fleet {

/// Key of a fact. The epoch is incremented at each start of a vehicle's odometry: a new epoch is a
/// new odom frame.
struct FactKey {
  VehicleId vehicle;
  std::uint32_t epoch = 0;
  std::uint32_t seq = 0;  ///< running number of the vehicle's facts in this epoch, from 0
  constexpr auto operator<=>(const FactKey&) const = default;
};

/// A node of a vehicle's path and its constraint to the previous node: from LiDAR and inertial data
/// alone, never ranges (algorithms_fleet 8.3).
struct Increment {
  std::uint32_t node = 0;                 ///< running number of the nodes, from 0
  std::optional<std::uint32_t> keyframe;  ///< number of the keyframe created here
  bool begins = false;                    ///< a new map begins: no constraint to the previous node
  bool at_rest = false;
  bool degenerate = false;  ///< a direction of travel is unobservable to the LiDAR
  bool levelled = false;    ///< gravity and biases are estimated
  /// Filter estimate: linearisation point, and the path's shape where the LiDAR constrains it.
  geometry::SE3 T_odom_body;
  geometry::Vec3 v_odom_mps = geometry::Vec3::Zero();
  geometry::Vec3 gyro_bias_radps = geometry::Vec3::Zero();
  geometry::Vec3 accel_bias_mps2 = geometry::Vec3::Zero();
  /// Of accelerometer bias and gravity together: the specific force expected at constant speed, in
  /// its worst direction; 0: not known.
  double force_sigma_mps2 = 0.0;
  geometry::Vec3 g_odom_mps2 = geometry::Vec3(0.0, 0.0, -9.81);
  double level_sigma_rad = 0.0;  ///< of the direction of g_odom_mps2; 0: not known
  geometry::Mat6 covariance = geometry::Mat6::Zero();         ///< of geometry::boxplus
  geometry::Mat6 lidar_information = geometry::Mat6::Zero();  ///< boxplus order, zero where
                                                              ///< degenerate
  std::optional<graph::InertialFactor> inertial;  ///< from the previous node; i and j are not used
};

/// One range as one of its ends recorded it. The other end has the same range in its own facts.
struct RangeEntry {
  Time t;
  VehicleId from, to;  ///< as measured; one of them is the fact's vehicle
  std::uint8_t from_antenna = 0, to_antenna = 0;
  double range_m = 0.0;
  double sigma_m = 0.1;       ///< of this range, raised by signal and map
  geometry::SE3 T_odom_body;  ///< of the fact's vehicle, at t
  bool at_rest = false;       ///< the fact's vehicle was at standstill
};

/// The plausible ranges of about a second.
struct RangeBlock {
  std::vector<RangeEntry> ranges;  ///< by time
};

/// The downsampled points of a keyframe, in its body frame.
struct KeyframePoints {
  std::uint32_t keyframe = 0;
  geometry::SE3 T_body_lidar;  ///< origin of the rays
  PackedPoints points;
  bool refinement = false;  ///< finer points of a keyframe that is already known coarsely

  [[nodiscard]] std::size_t size() const { return points.size(); }
};

/// Loop closure: two keyframes that observe the same place.
struct Loop {
  KeyframeId from, to;
  geometry::SE3 T_from_to;
  /// Rotation in `to`, translation in `from` (graph::RelativePoseFactor); zero where degenerate.
  geometry::Mat6 information = geometry::Mat6::Zero();
  double overlap = 0.0;  ///< fraction of points with a correspondence
  double rms_m = 0.0;    ///< of the distances between corresponding points
  std::uint32_t from_epoch = 0, to_epoch = 0;
};

/// First fact of an epoch: identifies the vehicle.
struct EpochStart {
  std::string name;
  std::vector<geometry::Vec3> antennas_body_m;
};

/// A fact of a kind that only newer programs can read: stored, and forwarded unchanged.
struct UnreadBody {
  std::uint8_t kind = 0;
};

using FactBody = std::variant<EpochStart, Increment, RangeBlock, KeyframePoints, Loop, UnreadBody>;

struct Fact {
  FactKey key;
  Time t;
  FactBody body;
  /// Unread trailing bytes from a newer program, unchanged: a forwarded fact must not be shortened.
  std::vector<std::uint8_t> unread = {};
};

using FactPtr = std::shared_ptr<const Fact>;

}  // namespace rali::fleet
