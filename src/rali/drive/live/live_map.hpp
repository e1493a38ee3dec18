#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/fleet/centre/round_centre.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// Where a vehicle is in the map, as far as anybody could know at the time.
struct LivePose {
  Time t;
  geometry::SE3 T_map_body;
  geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< of geometry::boxplus
  bool contradicted = false;                           ///< the table, by the vehicle's own filter
};

/// T_map_odom changed under a vehicle's feet.
struct FrameStep {
  Time t;
  double shift_m = 0.0;  ///< of the body
  double turn_rad = 0.0;
  std::string reason;  ///< "joined", "table", "range", "lidar"
};

/// A vehicle had live poses in the map, and a later table no longer holds it there.
struct Withdrawal {
  VehicleId vehicle;
  Time t_joined, t_withdrawn;
  std::string reason;  ///< a sentence; may be empty
};

/// The fleet's map while it is made: from what the vehicles have reported so far a table is solved
/// now and then, which says where each vehicle's frame `local` lies in the map; in between, a
/// vehicle goes on from its last keyframe in the table. The map is that of the first vehicle:
/// origin and heading of its first pose, z up. A vehicle that a table no longer holds in this map
/// has no live pose until one does again. Where its own filter has meanwhile been corrected by more
/// than both may be wrong, either may be right: a live pose states the difference until a new table
/// is solved, which is due then.
class LiveMap {
 public:
  /// @param vehicles of the fleet, with a path or not
  LiveMap(std::size_t vehicles, const fleet::FleetSettings& settings, fleet::FleetKnowledge known);

  void add(const fleet::Fact& fact);

  /// Solves a new table if it is time for one. @param now data time
  void advance(Time now, Executor& executor);

  /// Nothing as long as the vehicle is not joined to the first one's map, or seeks gravity: until
  /// then it does not know which way the map is level. It is not waited for longer than 10 s.
  [[nodiscard]] std::optional<LivePose> pose(const vehicle::PoseEstimate& pose) const;

  /// The largest steps matter to who navigates in the map: those below a centimetre and half a
  /// degree are none. @param pose of which `live` was made
  [[nodiscard]] std::optional<FrameStep> step(const vehicle::PoseEstimate& pose,
                                              const LivePose& live);

  /// Those since the last call.
  [[nodiscard]] std::vector<Withdrawal> take_withdrawals();

 private:
  /// What the last table says of one vehicle.
  struct Entry {
    geometry::SE3 T_map_local;

    /// The keyframe it goes on from; none: the vehicle's frame is the map's.
    struct Keyframe {
      geometry::SE3 T_local_body, T_map_body;
      geometry::Mat6 covariance_local, covariance_map;
    };

    std::optional<Keyframe> from;
  };

  struct Member {
    std::optional<Entry> entry;
    std::size_t tables = 0;  ///< with an entry
    std::optional<Time> t_joined;
    std::optional<geometry::SE3> T_map_odom;
    std::size_t tables_seen = 0;                    ///< when T_map_odom was
    std::optional<geometry::SE3> T_map_odom_table;  ///< with the first pose after the last table
  };

  [[nodiscard]] bool is_due(Time now);
  void solve(Time now, Executor& executor);
  void take(const fleet::FleetEstimate& estimate, Time now);
  void withdraw(const fleet::VehicleFrame& frame, Time now);
  [[nodiscard]] geometry::Mat6 of_level(const geometry::SE3& T_map_body, double sigma_rad) const;
  /// How far the filter's corrections since the last table have moved the live pose.
  [[nodiscard]] std::optional<geometry::Vec6> contradiction(const vehicle::PoseEstimate& pose,
                                                            const LivePose& live) const;
  [[nodiscard]] Entry entry_of(const fleet::FleetEstimate& estimate,
                               const fleet::VehicleFrame& frame) const;
  [[nodiscard]] std::optional<VehicleId> reference(Time now) const;

  double level_sigma_rad_ = 0.0;  ///< of the map's roll and pitch, where gravity tells it
  fleet::RoundCentre centre_;
  std::vector<Member> members_;
  std::vector<Withdrawal> withdrawals_;
  std::optional<Time> begin_, due_;
  Time t_table_;                          ///< of the last table
  std::size_t paths_ = 0, levelled_ = 0;  ///< when the last table was solved
  VehicleId reference_;
};

}  // namespace rali::drive
