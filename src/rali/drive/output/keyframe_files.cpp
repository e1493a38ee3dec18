#include "rali/drive/output/keyframe_files.hpp"

#include <cstring>
#include <filesystem>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/cloud_writers.hpp"
#include "rali/io/files/text.hpp"
#include "rali/io/files/tum.hpp"

namespace rali::drive {
namespace {

constexpr std::size_t kPointBytes = 18;  ///< four float32 and a uint16, little endian

Status unpack(const std::string& path, odometry::KeyframeCloud& out) {
  const Result<io::CloudFile> file = io::read_cloud_file(path);
  if (!file) return fail(ErrorCode::kMachine, path, "a keyframe of this run can no longer be read");
  const std::size_t n = file->size();
  if (file->point_step != kPointBytes || file->data.size() < n * kPointBytes) {
    return fail(ErrorCode::kMachine, path, "a keyframe of this run was changed on disk");
  }
  for (std::vector<float>* v : {&out.x_m, &out.y_m, &out.z_m, &out.intensity}) v->resize(n);
  out.ring.resize(n);
  const std::byte* from = file->data.data();
  for (std::size_t i = 0; i < n; ++i, from += kPointBytes) {
    std::memcpy(&out.x_m[i], from, 4);
    std::memcpy(&out.y_m[i], from + 4, 4);
    std::memcpy(&out.z_m[i], from + 8, 4);
    std::memcpy(&out.intensity[i], from + 12, 4);
    std::memcpy(&out.ring[i], from + 16, 2);
  }
  return {};
}

}  // namespace

Result<KeyframeRecord> write_keyframe(const std::string& out_dir, const std::string& vehicle,
                                      const vehicle::KeyframeAdded& added) {
  const odometry::Keyframe& keyframe = *added.keyframe;
  KeyframeRecord record;
  record.id = added.id;
  record.t = keyframe.t;
  record.T_local_body = keyframe.T_odom_body;
  record.covariance = keyframe.covariance;
  record.T_previous_this = keyframe.T_previous_this;
  record.information_relative = keyframe.information_relative;
  record.T_body_lidar = keyframe.T_body_lidar;
  record.points = keyframe.cloud.size();
  record.has_rings = !keyframe.cloud.ring.empty();
  record.file = fmt::format("keyframes/{}/{:06d}.pcd", vehicle, added.id.seq);

  const std::string path = out_dir + '/' + record.file;
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), error);
  if (error) return fail(ErrorCode::kMachine, path, error.message());
  const odometry::KeyframeCloud& cloud = keyframe.cloud;
  const Status status =
      io::write_keyframe_pcd(path, {cloud.x_m, cloud.y_m, cloud.z_m, cloud.intensity, cloud.ring});
  if (!status) return tl::make_unexpected(status.error());
  return record;
}

map::KeyframeStream keyframe_stream(const std::string& out_dir,
                                    const std::vector<KeyframeRecord>& records,
                                    const geometry::SE3& T_map_local) {
  return [&out_dir, &records, T_map_local](const map::KeyframeVisitor& visit) -> Status {
    odometry::KeyframeCloud cloud;
    for (const KeyframeRecord& record : records) {
      if (record.diverged) continue;
      if (Status s = unpack(out_dir + '/' + record.file, cloud); !s) return s;
      map::KeyframeView view;
      view.t = record.t;
      view.vehicle = static_cast<std::uint8_t>(record.id.vehicle.value);
      view.T_map_body = T_map_local * record.T_local_body;
      // Rotation is perturbed in the body, position in the outer frame: only the position part
      // rotates.
      geometry::Mat6 J = geometry::Mat6::Identity();
      J.bottomRightCorner<3, 3>() = T_map_local.R;
      view.covariance = J * record.covariance * J.transpose();
      view.T_body_lidar = record.T_body_lidar;
      view.x_m = cloud.x_m;
      view.y_m = cloud.y_m;
      view.z_m = cloud.z_m;
      view.intensity = cloud.intensity;
      if (record.has_rings) view.ring = cloud.ring;
      visit(view);
    }
    return {};
  };
}

void remove_keyframes(const std::string& out_dir, const std::string& vehicle,
                      const std::vector<KeyframeRecord>& records) {
  std::error_code ignored;
  for (const KeyframeRecord& record : records) {
    std::filesystem::remove(out_dir + '/' + record.file, ignored);
  }
  std::filesystem::remove(out_dir + "/keyframes/" + vehicle, ignored);
}

std::string keyframes_text(const std::vector<VehicleKeyframes>& vehicles, bool with_files) {
  std::string text = "id,vehicle,seq,stamp_s,x,y,z,qx,qy,qz,qw,points,file\n";
  std::size_t id = 0;
  for (const VehicleKeyframes& vehicle : vehicles) {
    for (const KeyframeRecord& record : *vehicle.records) {
      if (record.diverged) continue;
      std::string pose = io::pose_text(vehicle.T_map_local * record.T_local_body, 6, 9);
      std::replace(pose.begin(), pose.end(), ' ', ',');
      text += fmt::format("{},{},{},{},{},{},{}\n", id++, vehicle.vehicle, record.id.seq,
                          io::format_stamp(record.t), pose, record.points,
                          with_files ? record.file : std::string());
    }
  }
  return text;
}

}  // namespace rali::drive
