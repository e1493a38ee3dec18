#include "rali/drive/output/session_file.hpp"

#include <algorithm>
#include <utility>

#include "rali/drive/output/pose_diagnostics.hpp"
#include "rali/wire/cloud_pack.hpp"
#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::drive {
namespace {

constexpr std::uint64_t kScanStep = 5;
constexpr double kDiagnosticsStep_s = 1.0;
constexpr auto kCdr = wire::Encoding::kCdr;

/// MCAP log times count from 1970: boot clock stamps are valid, older stamps are clamped.
Time log_time(Time t) { return std::max(t, Time{}); }

wire::TransformStamped transform(Time t, std::string frame, std::string child,
                                 const geometry::SE3& T) {
  return {t, std::move(frame), std::move(child), T};
}

}  // namespace

SessionFile::SessionFile(io::AtomicFile file)
    : sink_(std::move(file)), mcap_(sink_, io::McapWriter::Options{}) {}

SessionFile::~SessionFile() = default;

Result<std::unique_ptr<SessionFile>> SessionFile::create(const std::string& out_dir) {
  Result<io::AtomicFile> file = io::AtomicFile::create(out_dir + "/session.mcap");
  if (!file) return tl::make_unexpected(file.error());
  return std::unique_ptr<SessionFile>(new SessionFile(std::move(*file)));
}

Status SessionFile::write(const std::string& topic, const std::string& type, Time t,
                          const wire::Bytes& bytes) {
  auto channel = channels_.find(topic);
  if (channel == channels_.end()) {
    auto schema = schemas_.find(type);
    if (schema == schemas_.end()) {
      const Result<std::uint16_t> id =
          mcap_.add_schema(type, "ros2msg", wire::message_definition(type, kCdr));
      if (!id) return tl::make_unexpected(id.error());
      schema = schemas_.emplace(type, *id).first;
    }
    const Result<std::uint16_t> id = mcap_.add_channel(schema->second, topic, "cdr");
    if (!id) return tl::make_unexpected(id.error());
    channel = channels_.emplace(topic, *id).first;
  }
  return mcap_.write(channel->second, log_time(t), log_time(t), bytes);
}

void SessionFile::set_lidar(const std::string& vehicle, const geometry::SE3& T_body_lidar) {
  T_body_lidar_[vehicle] = T_body_lidar;
}

Status SessionFile::add_scan(const std::string& vehicle, const sensor::LidarScan& scan) {
  const std::uint64_t count = scans_[vehicle]++;
  if (count == 0) {
    wire::TfMessage tf;
    tf.transforms.push_back(
        transform(scan.t_end, vehicle + "/base_link", vehicle + "/lidar", T_body_lidar_[vehicle]));
    const Status status =
        write("/tf_static", "tf2_msgs/msg/TFMessage", scan.t_end, wire::encode(tf, kCdr));
    if (!status) return status;
  }
  if (count % kScanStep != 0) return {};
  const wire::PackedCloud cloud = wire::pack_cloud(
      scan, vehicle + "/lidar", wire::CloudStyle::kVelodyne, wire::HeaderStamp::kEnd);
  return write("/" + vehicle + "/scan", "sensor_msgs/msg/PointCloud2", scan.t_end,
               wire::encode(cloud.view, kCdr));
}

Status SessionFile::add_pose(const std::string& vehicle, const PoseRecord& pose) {
  reported_[vehicle].emplace_back(pose.t, pose.T_odom_body);
  wire::TfMessage tf;
  tf.transforms.push_back(
      transform(pose.t, vehicle + "/odom", vehicle + "/base_link", pose.T_odom_body));
  Status status = write("/tf", "tf2_msgs/msg/TFMessage", pose.t, wire::encode(tf, kCdr));
  if (!status) return status;
  const wire::PoseStamped stamped{pose.t, vehicle + "/odom", pose.T_odom_body};
  status = write("/" + vehicle + "/pose", "geometry_msgs/msg/PoseStamped", pose.t,
                 wire::encode(stamped, kCdr));
  if (!status) return status;
  wire::DiagnosticArray diagnostics;
  diagnostics.stamp = pose.t;
  diagnostics.frame_id = vehicle + "/odom";
  diagnostics.status.push_back(degeneracy_status(vehicle, pose));
  status = write("/" + vehicle + "/degeneracy", "diagnostic_msgs/msg/DiagnosticArray", pose.t,
                 wire::encode(diagnostics, kCdr));
  return status ? diagnose(vehicle, pose) : status;
}

/// /diagnostics: once a second for each vehicle, as robot monitors expect; a change for the worse
/// at once.
Status SessionFile::diagnose(const std::string& vehicle, const PoseRecord& pose) {
  const auto last = t_diagnosed_.find(vehicle);
  const bool due = last == t_diagnosed_.end() ||
                   seconds_between(last->second, pose.t) >= kDiagnosticsStep_s ||
                   pose.quality == vehicle::PoseQuality::kDiverged;
  if (!due) return {};
  t_diagnosed_[vehicle] = pose.t;
  wire::DiagnosticArray diagnostics;
  diagnostics.stamp = pose.t;
  diagnostics.status = {pose_status(vehicle, pose), degeneracy_status(vehicle, pose)};
  return write("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", pose.t,
               wire::encode(diagnostics, kCdr));
}

/// The poses of odom in map that map the published poses to the final ones.
Status SessionFile::write_frames(const std::string& vehicle, const std::vector<PoseRecord>& poses,
                                 const geometry::SE3& T_map_local) {
  const std::vector<std::pair<Time, geometry::SE3>>& reported = reported_[vehicle];
  for (std::size_t i = 0; i < std::min(poses.size(), reported.size()); ++i) {
    wire::TfMessage tf;
    const geometry::SE3 T_map_body = T_map_local * poses[i].T_local_body;
    tf.transforms.push_back(transform(reported[i].first, "map", vehicle + "/odom",
                                      T_map_body * reported[i].second.inverse()));
    const Status status =
        write("/tf", "tf2_msgs/msg/TFMessage", reported[i].first, wire::encode(tf, kCdr));
    if (!status) return status;
  }
  return {};
}

Status SessionFile::add_path(const std::string& vehicle, const std::vector<PoseRecord>& poses,
                             const geometry::SE3& T_map_local) {
  if (poses.empty()) return {};
  if (Status status = write_frames(vehicle, poses, T_map_local); !status) return status;
  wire::Path path;
  path.stamp = poses.back().t;
  path.frame_id = "map";
  for (const PoseRecord& pose : poses) {
    if (pose.quality == vehicle::PoseQuality::kDiverged) continue;
    path.poses.push_back({pose.t, "map", T_map_local * pose.T_local_body});
  }
  return write("/" + vehicle + "/path", "nav_msgs/msg/Path", path.stamp, wire::encode(path, kCdr));
}

Status SessionFile::add_cloud(const std::string& topic, const wire::CloudView& cloud) {
  return write(topic, "sensor_msgs/msg/PointCloud2", cloud.stamp, wire::encode(cloud, kCdr));
}

Status SessionFile::add_markers(const std::string& topic, Time t,
                                const wire::MarkerArray& markers) {
  return write(topic, "visualization_msgs/msg/MarkerArray", t, wire::encode(markers, kCdr));
}

Status SessionFile::finish() {
  if (Status status = mcap_.close(); !status) return status;
  return sink_.commit();
}

}  // namespace rali::drive
