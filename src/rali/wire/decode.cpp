#include "rali/wire/decode.hpp"

#include <cmath>

#include <fmt/format.h>

#include "rali/wire/byte_reader.hpp"

namespace rali::wire {
namespace {

// A field list longer than this is damage, not a driver.
constexpr std::uint32_t kFieldsMax = 1000;
constexpr std::size_t kFieldBytesMin = 4 + 4 + 1 + 4;

template <class T>
Result<T> finish(const ByteReader& in, std::string_view type, T value) {
  if (!in.ok()) return tl::make_unexpected(in.error(type));
  return value;
}

geometry::Vec3 vector3(ByteReader& in) {
  const auto v = in.get_array<double, 3>();
  return {v[0], v[1], v[2]};
}

/// Reads x y z w; false if it is not a rotation.
bool rotation(ByteReader& in, geometry::Mat3& R) {
  const auto q = in.get_array<double, 4>();
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(norm > 1e-6) || !std::isfinite(norm)) return false;
  const double x = q[0] / norm, y = q[1] / norm, z = q[2] / norm, w = q[3] / norm;
  R << 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
      2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),   //
      2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y);
  return true;
}

}  // namespace

Result<CloudView> decode_point_cloud2(std::span<const std::byte> message, Encoding encoding) {
  ByteReader in(message, encoding);
  CloudView cloud;
  const ByteReader::Header header = in.header();
  cloud.stamp = header.stamp;
  cloud.frame_id = header.frame_id;
  cloud.height = in.get<std::uint32_t>();
  cloud.width = in.get<std::uint32_t>();
  const std::uint32_t fields = in.sequence(kFieldBytesMin);
  if (in.ok() && fields > kFieldsMax) {
    return fail(ErrorCode::kInput, fmt::format("byte {}", in.offset()),
                fmt::format("a PointCloud2 claims {} fields", fields), "The message is left out.");
  }
  cloud.fields.reserve(fields);
  for (std::uint32_t i = 0; i < fields && in.ok(); ++i) {
    CloudField field;
    field.name = in.string();
    field.offset = in.get<std::uint32_t>();
    field.type = static_cast<FieldType>(in.get<std::uint8_t>());
    field.count = in.get<std::uint32_t>();
    cloud.fields.push_back(std::move(field));
  }
  cloud.big_endian = in.get<std::uint8_t>() != 0;
  cloud.point_step = in.get<std::uint32_t>();
  cloud.row_step = in.get<std::uint32_t>();
  cloud.data = in.bytes(in.sequence(1));
  return finish(in, "PointCloud2", std::move(cloud));
}

Result<CloudView> decode_livox_custom(std::span<const std::byte> message, Encoding encoding) {
  ByteReader in(message, encoding);
  CloudView cloud;
  const ByteReader::Header header = in.header();
  const auto timebase_ns = in.get<std::uint64_t>();
  cloud.stamp = header.stamp;
  constexpr std::uint64_t kTimebaseMax = 9'000'000'000'000'000'000;  // beyond: invalid
  if (header.stamp.ns == 0 && timebase_ns < kTimebaseMax) {
    cloud.stamp = Time::from_ns(static_cast<std::int64_t>(timebase_ns));
  }
  cloud.frame_id = header.frame_id;
  // point_num repeats the length of the list, which is used instead.
  static_cast<void>(in.get<std::uint32_t>());
  in.skip(4);  // lidar_id, rsvd[3]
  constexpr std::uint32_t kPointBytes = 19;
  const std::uint32_t points = in.sequence(kPointBytes);
  in.align(4);
  // In CDR each point starts at a multiple of 4; no padding follows the last one.
  const std::uint32_t step = encoding == Encoding::kCdr ? 20 : kPointBytes;
  const std::size_t bytes = points == 0 ? 0 : std::size_t{points - 1} * step + kPointBytes;
  cloud.data = in.bytes(bytes);
  cloud.height = 1;
  cloud.width = points;
  cloud.point_step = step;
  cloud.row_step = step * points;
  cloud.big_endian = in.big_endian();
  cloud.fields = {{"offset_time", 0, FieldType::kUint32, 1},  {"x", 4, FieldType::kFloat32, 1},
                  {"y", 8, FieldType::kFloat32, 1},           {"z", 12, FieldType::kFloat32, 1},
                  {"reflectivity", 16, FieldType::kUint8, 1}, {"tag", 17, FieldType::kUint8, 1},
                  {"line", 18, FieldType::kUint8, 1}};
  return finish(in, "Livox CustomMsg", std::move(cloud));
}

Result<CloudView> decode_cloud_message(MessageKind kind, std::span<const std::byte> message,
                                       Encoding encoding) {
  if (kind == MessageKind::kPointCloud2) return decode_point_cloud2(message, encoding);
  if (kind == MessageKind::kLivoxCustom) return decode_livox_custom(message, encoding);
  return fail(ErrorCode::kInput, {}, "this topic holds no point cloud");
}

Result<ImuMessage> decode_imu(std::span<const std::byte> message, Encoding encoding) {
  ByteReader in(message, encoding);
  ImuMessage imu;
  ByteReader::Header header = in.header();
  imu.sample.t = header.stamp;
  imu.frame_id = std::move(header.frame_id);
  constexpr std::size_t kCovariance = 9 * sizeof(double);
  static_cast<void>(in.get_array<double, 4>());
  in.skip(kCovariance);
  imu.sample.gyro_radps = vector3(in);
  in.skip(kCovariance);
  imu.sample.accel_mps2 = vector3(in);
  in.skip(kCovariance);
  return finish(in, "Imu", std::move(imu));
}

Result<TfMessage> decode_tf(std::span<const std::byte> message, Encoding encoding) {
  ByteReader in(message, encoding);
  constexpr std::size_t kTransformBytesMin = 16 + 56;
  const std::uint32_t count = in.sequence(kTransformBytesMin);
  TfMessage tf;
  for (std::uint32_t i = 0; i < count && in.ok(); ++i) {
    TransformStamped transform;
    ByteReader::Header header = in.header();
    transform.stamp = header.stamp;
    transform.frame_id = std::move(header.frame_id);
    transform.child_frame_id = in.string();
    transform.T_frame_child.p = vector3(in);
    if (rotation(in, transform.T_frame_child.R)) {
      tf.transforms.push_back(std::move(transform));
    } else {
      ++tf.refused;
    }
  }
  return finish(in, "TFMessage", std::move(tf));
}

Result<PoseStamped> decode_pose_stamped(std::span<const std::byte> message, Encoding encoding) {
  ByteReader in(message, encoding);
  PoseStamped pose;
  ByteReader::Header header = in.header();
  pose.stamp = header.stamp;
  pose.frame_id = std::move(header.frame_id);
  pose.T_frame_body.p = vector3(in);
  if (!rotation(in, pose.T_frame_body.R) && in.ok()) {
    return fail(ErrorCode::kInput, {}, "a PoseStamped has no rotation (quaternion of length 0)");
  }
  return finish(in, "PoseStamped", std::move(pose));
}

Result<Odometry> decode_odometry(std::span<const std::byte> message, Encoding encoding) {
  ByteReader in(message, encoding);
  Odometry odometry;
  ByteReader::Header header = in.header();
  odometry.stamp = header.stamp;
  odometry.frame_id = std::move(header.frame_id);
  odometry.child_frame_id = in.string();
  odometry.T_frame_child.p = vector3(in);
  if (!rotation(in, odometry.T_frame_child.R) && in.ok()) {
    return fail(ErrorCode::kInput, {}, "an Odometry has no rotation (quaternion of length 0)");
  }
  const auto covariance = in.get_array<double, 36>();
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 6; ++col) {
      odometry.pose_covariance(row, col) = covariance[static_cast<std::size_t>(6 * row + col)];
    }
  }
  odometry.v_child_mps = vector3(in);
  odometry.omega_child_radps = vector3(in);
  in.skip(36 * sizeof(double));  // covariance of the velocity
  return finish(in, "Odometry", std::move(odometry));
}

Result<RangeMessage> decode_range(std::span<const std::byte> message, Encoding encoding) {
  ByteReader in(message, encoding);
  RangeMessage range;
  ByteReader::Header header = in.header();
  range.stamp = header.stamp;
  range.antenna = std::move(header.frame_id);
  range.from = in.string();
  range.to = in.string();
  range.range_m = in.get<double>();
  range.sigma_m = in.get<float>();
  range.rssi_dbm = in.get<float>();
  range.rssi_first_path_dbm = in.get<float>();
  range.device_time_ns = in.get<std::uint64_t>();
  range.flags = in.get<std::uint8_t>();
  return finish(in, "rali_msgs/Range", std::move(range));
}

}  // namespace rali::wire
