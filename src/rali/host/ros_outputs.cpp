#include "rali/host/ros_outputs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "rali/drive/output/pose_diagnostics.hpp"
#include "rali/wire/encode.hpp"

namespace rali::host {
namespace {

constexpr auto kCdr = wire::Encoding::kCdr;
constexpr double kFrontierSize_m = 0.6;

struct TopicRow {
  RosTopicId id;
  bool of_vehicle;  ///< /<v>/name
  const char* name;
  const char* type;
  net::RosQos qos;
};

constexpr TopicRow kRows[] = {
    {RosTopicId::kOdom, true, "odom", "nav_msgs/msg/Odometry", {true, false, 10}},
    {RosTopicId::kTf, false, "tf", "tf2_msgs/msg/TFMessage", {true, false, 100}},
    {RosTopicId::kTfStatic, false, "tf_static", "tf2_msgs/msg/TFMessage", {true, true, 1}},
    {RosTopicId::kDegeneracy,
     true,
     "degeneracy",
     "diagnostic_msgs/msg/DiagnosticArray",
     {true, false, 10}},
    {RosTopicId::kDiagnostics,
     false,
     "diagnostics",
     "diagnostic_msgs/msg/DiagnosticArray",
     {true, false, 10}},
    {RosTopicId::kMap, false, "map", "nav_msgs/msg/OccupancyGrid", {true, true, 1}},
    {RosTopicId::kMapCloud, false, "map_cloud", "sensor_msgs/msg/PointCloud2", {true, true, 1}},
    {RosTopicId::kMapDelta, true, "map_delta", "sensor_msgs/msg/PointCloud2", {true, false, 10}},
    {RosTopicId::kFrontiers,
     false,
     "frontiers",
     "visualization_msgs/msg/MarkerArray",
     {true, true, 1}},
    {RosTopicId::kGoalPose, true, "goal_pose", "geometry_msgs/msg/PoseStamped", {true, true, 1}},
    {RosTopicId::kRanges, false, "ranges", "rali_msgs/msg/Range", {false, false, 50}},
    {RosTopicId::kRole, false, "role", "std_msgs/msg/String", {true, false, 10}},
};
static_assert(std::size(kRows) == kRosTopics);

float known_or_nan(double dbm) {
  return dbm == 0.0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(dbm);
}

wire::Marker sphere_list(Time t) {
  wire::Marker m;
  m.stamp = t;
  m.frame_id = "map";
  m.ns = "frontiers";
  m.type = wire::Marker::kSphereList;
  m.scale_m = {kFrontierSize_m, kFrontierSize_m, kFrontierSize_m};
  m.rgba = {0.94F, 0.89F, 0.26F, 0.9F};
  return m;
}

geometry::SE3 facing(const geometry::Vec3& from_map_m, const geometry::Vec3& to_map_m) {
  const geometry::Vec3 d = to_map_m - from_map_m;
  return {geometry::rotation_from_rpy(0.0, 0.0, std::atan2(d.y(), d.x())), to_map_m};
}

}  // namespace

std::string ros_name(const std::string& vehicle) {
  std::string name = vehicle;
  std::replace(name.begin(), name.end(), '-', '_');
  const bool digit = !name.empty() && name.front() >= '0' && name.front() <= '9';
  return digit ? 'v' + name : name;  // no part of a ROS name begins with a digit
}

net::RosTopic ros_topic(RosTopicId id, const std::string& name) {
  const TopicRow& row = kRows[static_cast<std::size_t>(id)];
  const std::string prefix = row.of_vehicle ? '/' + ros_name(name) + '/' : "/";
  return {prefix + row.name, row.type, row.qos};
}

RosOut RosOutputs::mounting(const sensor::Calibration& calibration, Time t) const {
  wire::TfMessage tf;
  const std::string body = vehicle_ + "/base_link";
  tf.transforms.push_back({t, body, vehicle_ + "/lidar", calibration.T_body_lidar});
  tf.transforms.push_back({t, body, vehicle_ + "/imu", calibration.T_body_imu});
  return {RosTopicId::kTfStatic, t, wire::encode(tf, kCdr)};
}

void RosOutputs::pose(const vehicle::PoseEstimate& pose,
                      const std::optional<geometry::SE3>& T_map_local, std::vector<RosOut>& out) {
  const std::string odom = vehicle_ + "/odom", body = vehicle_ + "/base_link";
  wire::Odometry message;
  message.stamp = pose.t;
  message.frame_id = odom;
  message.child_frame_id = body;
  message.T_frame_child = pose.T_odom_body;
  message.pose_covariance = geometry::covariance_fixed_axes(pose.covariance, pose.T_odom_body.R);
  message.v_child_mps = pose.T_odom_body.R.transpose() * pose.v_odom_mps;
  if (last_ && pose.t > last_->t) {
    const geometry::Mat3 turn = last_->T_odom_body.R.transpose() * pose.T_odom_body.R;
    message.omega_child_radps = geometry::so3_log(turn) / seconds_between(last_->t, pose.t);
  }
  last_ = pose;
  out.push_back({RosTopicId::kOdom, pose.t, wire::encode(message, kCdr)});

  wire::TfMessage tf;
  if (T_map_local) {
    const geometry::SE3 T_map_odom = *T_map_local * pose.T_local_body * pose.T_odom_body.inverse();
    tf.transforms.push_back({pose.t, "map", odom, T_map_odom});
  }
  tf.transforms.push_back({pose.t, odom, body, pose.T_odom_body});
  out.push_back({RosTopicId::kTf, pose.t, wire::encode(tf, kCdr)});

  wire::DiagnosticArray degeneracy;
  degeneracy.stamp = pose.t;
  degeneracy.frame_id = odom;
  degeneracy.status.push_back(drive::degeneracy_status(vehicle_, drive::pose_record(pose)));
  out.push_back({RosTopicId::kDegeneracy, pose.t, wire::encode(degeneracy, kCdr)});
}

std::optional<RosOut> RosOutputs::range(const sensor::RangeSample& range,
                                        const std::vector<std::string>& names) const {
  if (range.from.value >= names.size() || range.to.value >= names.size()) return std::nullopt;
  wire::RangeMessage message;
  message.stamp = range.t;
  message.from = names[range.from.value];
  message.to = names[range.to.value];
  message.range_m = range.range_m;
  message.sigma_m = static_cast<float>(range.sigma_m);
  message.rssi_dbm = known_or_nan(range.rssi_dbm);
  message.rssi_first_path_dbm = known_or_nan(range.first_path_dbm);
  return RosOut{RosTopicId::kRanges, range.t, wire::encode(message, kCdr)};
}

RosOut RosOutputs::frontiers(const fleet::GoalList& goals, Time t) const {
  wire::MarkerArray array;
  array.markers.push_back(sphere_list(t));
  array.markers.front().action = wire::Marker::kDeleteAll;
  array.markers.push_back(sphere_list(t));
  for (const fleet::Frontier& frontier : goals.frontiers) {
    array.markers.back().points_m.push_back(frontier.centre_map_m);
  }
  return {RosTopicId::kFrontiers, t, wire::encode(array, kCdr)};
}

RosOut RosOutputs::goal(const fleet::DriveOrder& order, const geometry::SE3& T_map_body,
                        Time t) const {
  wire::PoseStamped pose{t, "map", T_map_body};
  const auto& places = order.places_map_m;
  if (!places.empty()) {
    const geometry::Vec3& before = places.size() > 1 ? places[places.size() - 2] : T_map_body.p;
    pose.T_frame_body = facing(before, places.back());
  }
  return {RosTopicId::kGoalPose, t, wire::encode(pose, kCdr)};
}

RosOut RosOutputs::diagnostics(std::vector<wire::DiagnosticStatus> status, Time t) const {
  wire::DiagnosticArray array;
  array.stamp = t;
  array.status = std::move(status);
  return {RosTopicId::kDiagnostics, t, wire::encode(array, kCdr)};
}

RosOut RosOutputs::role(const std::string& text, Time t) const {
  return {RosTopicId::kRole, t, wire::encode_string(text, kCdr)};
}

}  // namespace rali::host
