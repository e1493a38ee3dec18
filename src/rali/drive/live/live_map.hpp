#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/fleet/centre/round_centre.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// A vehicle's pose in the map, as known at the time.
struct LivePose {
  Time t;
  geometry::SE3 T_map_body;
  geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< of geometry::boxplus
  bool contradicted = false;                           ///< the filter contradicts the table
};

/// A step of T_map_odom during the run.
struct FrameStep {
  Time t;
  double shift_m = 0.0;  ///< of the body
  double turn_rad = 0.0;
  std::string reason;  ///< "joined", "table", "range", "lidar"
};

/// A vehicle had live poses in the map, but a later table no longer has it in this map.
struct Withdrawal {
  VehicleId vehicle;
  Time t_joined, t_withdrawn;
  std::string reason;  ///< a sentence; may be empty
};

/// The fleet's map while it is made. From the facts reported so far a table is solved from time to
/// time; it gives the transform from each vehicle's frame `local` to the map. Between two tables, a
/// live pose continues from the vehicle's last keyframe in the table. The map frame is that of the
/// first vehicle: origin and heading of its first pose, z up. A vehicle that is not in this map in
/// a new table has no live pose until a table contains it again. If the vehicle's own filter has
/// since been corrected by more than both covariances explain, either may be right. The live pose
/// then includes the difference in its covariance, and a new table becomes due.
class LiveMap {
 public:
  /// @param vehicles number of vehicles in the fleet, with a path or not
  LiveMap(std::size_t vehicles, const fleet::FleetSettings& settings, fleet::FleetKnowledge known);

  void add(const fleet::FactPtr& fact);

  /// Solves a new table if one is due. @param now data time
  void advance(Time now, Executor& executor);

  /// Empty as long as the vehicle is not joined to the first one's map, or still estimates gravity:
  /// until then the level of the map is not known. This wait ends after 10 s.
  [[nodiscard]] std::optional<LivePose> pose(const vehicle::PoseEstimate& pose) const;

  /// The step of T_map_odom with this pose; steps below a centimetre and half a degree are ignored.
  /// @param pose of which `live` was made
  [[nodiscard]] std::optional<FrameStep> step(const vehicle::PoseEstimate& pose,
                                              const LivePose& live);

  /// The withdrawals since the last call.
  [[nodiscard]] std::vector<Withdrawal> take_withdrawals();

 private:
  /// What the last table contains of one vehicle.
  struct Entry {
    geometry::SE3 T_map_local;

    /// The keyframe from which live poses continue; none: the vehicle's frame is the map's.
    struct Keyframe {
      geometry::SE3 T_local_body, T_map_body;
      geometry::Mat6 covariance_local, covariance_map;
    };

    std::optional<Keyframe> from;
  };

  struct Member {
    std::optional<Entry> entry;
    std::size_t tables = 0;  ///< number of tables with an entry
    std::optional<Time> t_joined;
    std::optional<geometry::SE3> T_map_odom;
    std::size_t tables_seen = 0;                    ///< at the time of T_map_odom
    std::optional<geometry::SE3> T_map_odom_table;  ///< with the first pose after the last table
  };

  [[nodiscard]] bool is_due(Time now);
  void solve(Time now, Executor& executor);
  void take(const fleet::FleetEstimate& estimate, Time now);
  void withdraw(const fleet::VehicleFrame& frame, Time now);
  [[nodiscard]] geometry::Mat6 of_level(const geometry::SE3& T_map_body, double level_rad) const;
  [[nodiscard]] double level_sigma_of(const fleet::FleetEstimate& estimate,
                                      std::size_t group) const;
  /// How far the filter's corrections since the last table have moved the live pose.
  [[nodiscard]] std::optional<geometry::Vec6> contradiction(const vehicle::PoseEstimate& pose,
                                                            const LivePose& live) const;
  [[nodiscard]] Entry entry_of(const fleet::FleetEstimate& estimate,
                               const fleet::VehicleFrame& frame) const;
  [[nodiscard]] std::optional<VehicleId> reference(Time now) const;

  fleet::JointSettings joint_;
  double level_sigma_rad_ = 0.0;  ///< of roll and pitch of the last table's map; 0: of one vehicle
  fleet::RoundCentre centre_;
  std::vector<Member> members_;
  std::vector<Withdrawal> withdrawals_;
  std::optional<Time> begin_, due_;
  Time t_table_;                          ///< of the last table
  std::size_t paths_ = 0, levelled_ = 0;  ///< when the last table was solved
  VehicleId reference_;
};

}  // namespace rali::drive
