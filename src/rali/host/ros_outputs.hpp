#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rali/fleet/messages/messages.hpp"
#include "rali/fleet/node/events.hpp"
#include "rali/net/ros_bus.hpp"
#include "rali/sensor/calibration.hpp"
#include "rali/vehicle/event.hpp"
#include "rali/wire/byte_writer.hpp"
#include "rali/wire/messages.hpp"

namespace rali::host {

/// Topics that a vehicle publishes on its ROS domain.
enum class RosTopicId : std::uint8_t {
  kOdom,
  kTf,
  kTfStatic,
  kDegeneracy,
  kDiagnostics,
  kMap,
  kMapCloud,
  kMapDelta,
  kFrontiers,
  kGoalPose,
  kRanges,
  kRole,
  kCount
};
inline constexpr std::size_t kRosTopics = static_cast<std::size_t>(RosTopicId::kCount);

/// A message ready for publication.
struct RosOut {
  RosTopicId topic = RosTopicId::kOdom;
  Time t;
  wire::Bytes cdr;
};

/// Name, type and quality of service of a topic of vehicle `name`, as ROS 2 tools and Nav2 expect.
[[nodiscard]] net::RosTopic ros_topic(RosTopicId id, const std::string& name);

/// A vehicle's name as a valid ROS name: '-' becomes '_'.
[[nodiscard]] std::string ros_name(const std::string& vehicle);

/// Messages of one vehicle. Frames follow REP-105: map -> <v>/odom -> <v>/base_link -> <v>/lidar
/// and <v>/imu. The frame odom never jumps; corrections by the map are in map -> odom.
class RosOutputs {
 public:
  explicit RosOutputs(std::string vehicle) : vehicle_(ros_name(vehicle)) {}

  /// /tf_static, once the mounting is known.
  [[nodiscard]] RosOut mounting(const sensor::Calibration& calibration, Time t) const;

  /// /<v>/odom, /tf and /<v>/degeneracy of one pose.
  /// @param T_map_local of the last table; none: there is no map yet
  void pose(const vehicle::PoseEstimate& pose, const std::optional<geometry::SE3>& T_map_local,
            std::vector<RosOut>& out);

  /// /ranges. @param names of all vehicles by number
  [[nodiscard]] std::optional<RosOut> range(const sensor::RangeSample& range,
                                            const std::vector<std::string>& names) const;

  /// /frontiers. @param t stamp
  [[nodiscard]] RosOut frontiers(const fleet::GoalList& goals, Time t) const;

  /// /<v>/goal_pose: where to drive, or where to stand still.
  [[nodiscard]] RosOut goal(const fleet::DriveOrder& order, const geometry::SE3& T_map_body,
                            Time t) const;

  [[nodiscard]] RosOut diagnostics(std::vector<wire::DiagnosticStatus> status, Time t) const;

  /// /role: one line for people and scripts.
  [[nodiscard]] RosOut role(const std::string& text, Time t) const;

 private:
  std::string vehicle_;
  std::optional<vehicle::PoseEstimate> last_;  ///< for the turn rate
};

}  // namespace rali::host
