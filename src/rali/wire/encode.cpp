#include "rali/wire/encode.hpp"

#include <algorithm>
#include <cmath>

namespace rali::wire {
namespace {

void put(ByteWriter& out, const geometry::Vec3& v) {
  for (int i = 0; i < 3; ++i) out.put(v[i]);
}

/// Quaternion x y z w of R, w >= 0 (Shepperd: divides by the largest component).
void put_rotation(ByteWriter& out, const geometry::Mat3& R) {
  const double trace = R.trace();
  const std::array<double, 4> squares = {1 + 2 * R(0, 0) - trace, 1 + 2 * R(1, 1) - trace,
                                         1 + 2 * R(2, 2) - trace, 1 + trace};
  const auto largest = std::max_element(squares.begin(), squares.end()) - squares.begin();
  std::array<double, 4> q{};  // four times the products of the largest component with each
  if (largest == 3) {
    q = {R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1), squares[3]};
  } else if (largest == 0) {
    q = {squares[0], R(0, 1) + R(1, 0), R(0, 2) + R(2, 0), R(2, 1) - R(1, 2)};
  } else if (largest == 1) {
    q = {R(0, 1) + R(1, 0), squares[1], R(1, 2) + R(2, 1), R(0, 2) - R(2, 0)};
  } else {
    q = {R(0, 2) + R(2, 0), R(1, 2) + R(2, 1), squares[2], R(1, 0) - R(0, 1)};
  }
  double norm = 0.0;
  for (const double value : q) norm += value * value;
  norm = q[3] < 0.0 ? -std::sqrt(norm) : std::sqrt(norm);
  for (const double value : q) out.put(value / norm);
}

void put(ByteWriter& out, const geometry::SE3& T) {
  put(out, T.p);
  put_rotation(out, T.R);
}

void put_zeros(ByteWriter& out, int doubles) {
  for (int i = 0; i < doubles; ++i) out.put(0.0);
}

void put(ByteWriter& out, const PoseStamped& pose) {
  out.header(pose.stamp, pose.frame_id);
  put(out, pose.T_frame_body);
}

void put(ByteWriter& out, const std::array<float, 4>& rgba) {
  for (const float value : rgba) out.put(value);
}

/// The fields added by ROS 2: texture, texture file, coordinates, mesh file.
void put_no_texture(ByteWriter& out) {
  out.string("");          // texture_resource
  out.header(Time{}, "");  // texture: sensor_msgs/CompressedImage
  out.string("");
  out.sequence(0);
  out.sequence(0);  // uv_coordinates
}

void put(ByteWriter& out, const Marker& marker) {
  const bool ros2 = out.encoding() == Encoding::kCdr;
  out.header(marker.stamp, marker.frame_id);
  out.string(marker.ns);
  out.put(marker.id);
  out.put(static_cast<std::int32_t>(marker.type));
  out.put(static_cast<std::int32_t>(marker.action));
  put(out, marker.T_frame_marker);
  for (const double value : marker.scale_m) out.put(value);
  put(out, marker.rgba);
  out.time(Time{} + marker.lifetime);
  out.put(std::uint8_t{0});  // frame_locked
  out.sequence(marker.points_m.size());
  for (const geometry::Vec3& point : marker.points_m) put(out, point);
  out.sequence(marker.colors.size());
  for (const auto& color : marker.colors) put(out, color);
  if (ros2) put_no_texture(out);
  out.string(marker.text);
  out.string("");  // mesh_resource
  if (ros2) {      // mesh_file: name and bytes
    out.string("");
    out.sequence(0);
  }
  out.put(std::uint8_t{0});  // mesh_use_embedded_materials
}

/// Bytes missing after the last point, which in a Livox message in CDR lacks its padding. A larger
/// lack means that point_step contradicts the data; such a cloud is written unchanged.
std::size_t lacking_bytes(const CloudView& cloud) {
  constexpr std::size_t kPaddingMax = 64;
  if (cloud.point_step == 0) return 0;
  const std::size_t over = cloud.data.size() % cloud.point_step;
  const std::size_t lacking = over == 0 ? 0 : cloud.point_step - over;
  return lacking <= kPaddingMax ? lacking : 0;
}

}  // namespace

Bytes encode(const CloudView& cloud, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  out.reserve(cloud.data.size() + 512);
  out.header(cloud.stamp, cloud.frame_id);
  out.put(cloud.height);
  out.put(cloud.width);
  out.sequence(cloud.fields.size());
  for (const CloudField& field : cloud.fields) {
    out.string(field.name);
    out.put(field.offset);
    out.put(static_cast<std::uint8_t>(field.type));
    out.put(field.count);
  }
  out.put(static_cast<std::uint8_t>(cloud.big_endian ? 1 : 0));
  out.put(cloud.point_step);
  out.put(cloud.row_step);
  const std::size_t lacking = lacking_bytes(cloud);
  out.sequence(cloud.data.size() + lacking);
  out.bytes(cloud.data);
  for (std::size_t i = 0; i < lacking; ++i) out.put(std::uint8_t{0});
  out.put(std::uint8_t{0});  // is_dense: never promised
  return out.take();
}

Bytes encode(const ImuMessage& imu, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  out.header(imu.sample.t, imu.frame_id);
  put_zeros(out, 3);
  out.put(1.0);
  out.put(-1.0);
  put_zeros(out, 8);
  put(out, imu.sample.gyro_radps);
  put_zeros(out, 9);
  put(out, imu.sample.accel_mps2);
  put_zeros(out, 9);
  return out.take();
}

Bytes encode(const TfMessage& tf, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  out.sequence(tf.transforms.size());
  for (const TransformStamped& transform : tf.transforms) {
    out.header(transform.stamp, transform.frame_id);
    out.string(transform.child_frame_id);
    put(out, transform.T_frame_child);
  }
  return out.take();
}

Bytes encode(const PoseStamped& pose, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  put(out, pose);
  return out.take();
}

Bytes encode(const Odometry& odometry, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  out.header(odometry.stamp, odometry.frame_id);
  out.string(odometry.child_frame_id);
  put(out, odometry.T_frame_child);
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) out.put(odometry.pose_covariance(row, column));
  }
  put(out, odometry.v_child_mps);
  put(out, odometry.omega_child_radps);
  put_zeros(out, 36);
  return out.take();
}

Bytes encode(const GridMessage& grid, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  out.reserve(grid.cells.size() + 256);
  out.header(grid.stamp, grid.frame_id);
  out.time(grid.stamp);  // map_load_time
  out.put(grid.cell_m);
  out.put(grid.width);
  out.put(grid.height);
  put(out, geometry::SE3{geometry::Mat3::Identity(),
                         geometry::Vec3(grid.origin_m.x(), grid.origin_m.y(), 0.0)});
  out.sequence(grid.cells.size());
  out.bytes(std::as_bytes(std::span(grid.cells)));
  return out.take();
}

Bytes encode(const Path& path, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  out.header(path.stamp, path.frame_id);
  out.sequence(path.poses.size());
  for (const PoseStamped& pose : path.poses) put(out, pose);
  return out.take();
}

Bytes encode(const DiagnosticArray& array, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  out.header(array.stamp, array.frame_id);
  out.sequence(array.status.size());
  for (const DiagnosticStatus& status : array.status) {
    out.put(static_cast<std::uint8_t>(status.level));
    out.string(status.name);
    out.string(status.message);
    out.string(status.hardware_id);
    out.sequence(status.values.size());
    for (const auto& value : status.values) {
      out.string(value.first);
      out.string(value.second);
    }
  }
  return out.take();
}

Bytes encode(const Marker& marker, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  put(out, marker);
  return out.take();
}

Bytes encode(const MarkerArray& markers, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  out.sequence(markers.markers.size());
  for (const Marker& marker : markers.markers) put(out, marker);
  return out.take();
}

Bytes encode(const RangeMessage& range, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  out.header(range.stamp, range.antenna);
  out.string(range.from);
  out.string(range.to);
  out.put(range.range_m);
  out.put(range.sigma_m);
  out.put(range.rssi_dbm);
  out.put(range.rssi_first_path_dbm);
  out.put(range.device_time_ns);
  out.put(range.flags);
  return out.take();
}

Bytes encode(const LivoxCustom& cloud, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  out.reserve(cloud.points.size() * 20 + 128);
  out.header(cloud.stamp, cloud.frame_id);
  out.put(cloud.timebase_ns);
  out.put(static_cast<std::uint32_t>(cloud.points.size()));
  out.put(cloud.lidar_id);
  for (int i = 0; i < 3; ++i) out.put(std::uint8_t{0});
  out.sequence(cloud.points.size());
  for (const LivoxPoint& point : cloud.points) {
    out.put(point.offset_time_ns);
    out.put(point.x_m);
    out.put(point.y_m);
    out.put(point.z_m);
    out.put(point.reflectivity);
    out.put(point.tag);
    out.put(point.line);
  }
  return out.take();
}

Bytes encode_string(std::string_view text, Encoding encoding, bool big_endian) {
  ByteWriter out(encoding, big_endian);
  out.string(text);
  return out.take();
}

}  // namespace rali::wire
