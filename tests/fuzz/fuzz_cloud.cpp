// Any cloud layout with any points, whatever drivers send: the format decision and the decoder must
// neither crash nor violate their contracts (see the checks below).
//
// Input: 24 bytes of layout, 4 per field, then the points' bytes, given to one to three clouds.
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "rali/wire/cloud_format.hpp"

namespace {

using namespace rali;
using wire::CloudView;

constexpr const char* kNames[] = {
    "x",   "y",    "z",       "intensity",   "ring", "t",  "time",         "timestamp",
    "tag", "line", "channel", "return_type", "y",    "dt", "reflectivity", ""};

struct Input {
  std::span<const std::uint8_t> rest;

  std::uint32_t take(std::size_t bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes && !rest.empty(); ++i) {
      value |= static_cast<std::uint32_t>(rest[0]) << (8 * i);
      rest = rest.subspan(1);
    }
    return value;
  }
};

void check(bool promise) {
  if (!promise) std::abort();
}

void check_scan(const sensor::LidarScan& scan, const CloudView& cloud,
                const wire::CloudFormatOptions& options) {
  const std::size_t n = scan.size();
  check(scan.y_m.size() == n && scan.z_m.size() == n && scan.intensity.size() == n &&
        scan.dt_s.size() == n && scan.ring.size() == n);
  const std::uint64_t claimed = std::uint64_t{cloud.width} * cloud.height;
  check(n + scan.dropped_nan + scan.dropped_range + scan.dropped_time + scan.dropped_return ==
        claimed);
  check(scan.t_end >= scan.t_start);
  for (std::size_t i = 0; i < n; ++i) {
    const double range_m =
        std::hypot(static_cast<double>(scan.x_m[i]), static_cast<double>(scan.y_m[i]),
                   static_cast<double>(scan.z_m[i]));
    check(range_m > options.range_m[0] * 0.999 && range_m < options.range_m[1] * 1.001);
    check(scan.dt_s[i] >= 0.0F && scan.dt_s[i] < 10.0F);
    check(!scan.has_rings || scan.ring[i] < scan.rings);
  }
}

CloudView read_layout(Input& in, std::size_t& clouds) {
  CloudView view;
  const std::uint32_t flags = in.take(1);
  view.big_endian = (flags & 1U) != 0;
  clouds = 1 + (flags >> 1) % 3;
  view.height = in.take((flags & 8U) != 0 ? 4 : 1);
  view.width = in.take((flags & 16U) != 0 ? 4 : 2);
  view.point_step = in.take(1);
  view.row_step = in.take(2);
  view.stamp = Time::from_ns(static_cast<std::int64_t>(in.take(4)) * 1'000'000'000);
  const std::uint32_t fields = in.take(1) % 12;
  for (std::uint32_t i = 0; i < fields; ++i) {
    wire::CloudField field;
    field.name = kNames[in.take(1) % 16];
    field.offset = in.take(1);
    field.type = static_cast<wire::FieldType>(in.take(1) % 10);
    field.count = in.take(1);
    view.fields.push_back(field);
  }
  return view;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input in{{data, size}};
  wire::CloudFormatOptions options;
  const std::uint32_t fixed = in.take(1);
  options.point_time = static_cast<wire::PointTime>(fixed % 9);
  options.header_stamp = static_cast<wire::HeaderStamp>((fixed >> 4) % 3);
  std::size_t count = 0;
  CloudView view = read_layout(in, count);
  view.data = std::as_bytes(in.rest);
  std::vector<CloudView> clouds(count, view);
  for (std::size_t i = 0; i < count; ++i) {
    clouds[i].stamp = view.stamp + Duration::from_ns(100'000'000 * static_cast<std::int64_t>(i));
  }
  const auto format = wire::decide_cloud_format(clouds, options);
  if (!format) {
    check(!format.error().what.empty());
    return 0;
  }
  check(!format->summary.empty());
  sensor::LidarScan scan;
  for (const CloudView& cloud : clouds) {
    if (wire::decode_cloud(cloud, *format, options, scan)) check_scan(scan, cloud, options);
  }
  return 0;
}
