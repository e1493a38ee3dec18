#include "rali/wire/cloud_pack.hpp"

#include <algorithm>
#include <cmath>

namespace rali::wire {
namespace {

using sensor::LidarScan;

struct Style {
  std::uint32_t point_step = 0;
  std::vector<CloudField> fields;
};

Style style_of(CloudStyle style) {
  constexpr auto kF32 = FieldType::kFloat32;
  constexpr auto kF64 = FieldType::kFloat64;
  constexpr auto kU8 = FieldType::kUint8;
  constexpr auto kU16 = FieldType::kUint16;
  constexpr auto kU32 = FieldType::kUint32;
  std::vector<CloudField> fields = {{"x", 0, kF32, 1}, {"y", 4, kF32, 1}, {"z", 8, kF32, 1}};
  const auto with = [&](std::uint32_t step, std::initializer_list<CloudField> more) {
    fields.insert(fields.end(), more);
    return Style{step, fields};
  };
  switch (style) {
    case CloudStyle::kVelodyne:
      return with(22, {{"intensity", 12, kF32, 1}, {"ring", 16, kU16, 1}, {"time", 18, kF32, 1}});
    case CloudStyle::kVelodynePcl:
      return with(32, {{"intensity", 16, kF32, 1}, {"ring", 20, kU16, 1}, {"time", 24, kF32, 1}});
    case CloudStyle::kOuster:
      return with(48, {{"intensity", 16, kF32, 1},
                       {"t", 20, kU32, 1},
                       {"reflectivity", 24, kU16, 1},
                       {"ring", 26, kU16, 1},
                       {"ambient", 28, kU16, 1},
                       {"range", 32, kU32, 1}});
    case CloudStyle::kRoboSense:
      return with(26,
                  {{"intensity", 12, kF32, 1}, {"ring", 16, kU16, 1}, {"timestamp", 18, kF64, 1}});
    case CloudStyle::kLivox:
      return with(26, {{"intensity", 12, kF32, 1},
                       {"tag", 16, kU8, 1},
                       {"line", 17, kU8, 1},
                       {"timestamp", 18, kF64, 1}});
    case CloudStyle::kXyzi:
      break;
  }
  return with(16, {{"intensity", 12, kF32, 1}});
}

class PointWriter {
 public:
  PointWriter(std::byte* point, bool big_endian) : point_(point), big_endian_(big_endian) {}

  template <class T>
  void at(std::uint32_t offset, T value) {
    if (big_endian_ != (std::endian::native == std::endian::big)) value = byte_swapped(value);
    std::memcpy(point_ + offset, &value, sizeof(T));
  }

 private:
  std::byte* point_;
  bool big_endian_;
};

void write_ouster(const LidarScan& scan, std::size_t i, double after_header_s, PointWriter& out) {
  out.at(16, scan.intensity[i]);
  out.at(20, static_cast<std::uint32_t>(std::llround(std::max(0.0, after_header_s) * 1e9)));
  out.at(26, scan.ring[i]);
  const auto range_m =
      std::hypot(static_cast<double>(scan.x_m[i]), static_cast<double>(scan.y_m[i]),
                 static_cast<double>(scan.z_m[i]));
  out.at(32, static_cast<std::uint32_t>(std::min(range_m, 4.0e6) * 1e3));
}

void write_point(const LidarScan& scan, std::size_t i, CloudStyle style, Duration start_to_header,
                 PointWriter& out) {
  out.at(0, scan.x_m[i]);
  out.at(4, scan.y_m[i]);
  out.at(8, scan.z_m[i]);
  const auto dt_s = static_cast<double>(scan.dt_s[i]);
  const double after_header_s = dt_s - start_to_header.s();
  const Time t = scan.t_start + Duration::from_s(dt_s);
  switch (style) {
    case CloudStyle::kVelodyne:
      out.at(12, scan.intensity[i]);
      out.at(16, scan.ring[i]);
      out.at(18, static_cast<float>(after_header_s));
      break;
    case CloudStyle::kVelodynePcl:
      out.at(16, scan.intensity[i]);
      out.at(20, scan.ring[i]);
      out.at(24, static_cast<float>(after_header_s));
      break;
    case CloudStyle::kOuster:
      write_ouster(scan, i, after_header_s, out);
      break;
    case CloudStyle::kRoboSense:
      out.at(12, scan.intensity[i]);
      out.at(16, scan.ring[i]);
      out.at(18, static_cast<double>(t.ns) * 1e-9);
      break;
    case CloudStyle::kLivox:
      out.at(12, scan.intensity[i]);
      out.at(17, static_cast<std::uint8_t>(scan.ring[i]));
      out.at(18, static_cast<double>(t.ns));
      break;
    case CloudStyle::kXyzi:
      out.at(12, scan.intensity[i]);
      break;
  }
}

}  // namespace

PackedCloud pack_cloud(const LidarScan& scan, std::string frame_id, CloudStyle style,
                       HeaderStamp header_stamp, bool big_endian) {
  const Style layout = style_of(style);
  PackedCloud cloud;
  cloud.view.stamp = header_stamp == HeaderStamp::kEnd ? scan.t_end : scan.t_start;
  cloud.view.frame_id = std::move(frame_id);
  cloud.view.height = 1;
  cloud.view.width = static_cast<std::uint32_t>(scan.size());
  cloud.view.point_step = layout.point_step;
  cloud.view.row_step = cloud.view.width * layout.point_step;
  cloud.view.big_endian = big_endian;
  cloud.view.fields = layout.fields;
  cloud.data.resize(scan.size() * layout.point_step);
  const Duration start_to_header = cloud.view.stamp - scan.t_start;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    PointWriter out(cloud.data.data() + i * layout.point_step, big_endian);
    write_point(scan, i, style, start_to_header, out);
  }
  cloud.view.data = cloud.data;
  return cloud;
}

}  // namespace rali::wire
