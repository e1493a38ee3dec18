#include <cmath>

#include "rali/wire/byte_reader.hpp"
#include "rali/wire/decode.hpp"

// Field lists: nlink_parser's msg folder. No frame had a header until 2023, when Nodeframe2 got one
// (and a unix_timestamp) under the same name. The length distinguishes the two versions, because
// both must end exactly where the message does.
namespace rali::wire {
namespace {

void add_range(LinktrackFrame& frame, const LinktrackNode& node) {
  if (std::isfinite(node.range_m) && node.range_m > 0.0) {
    frame.nodes.push_back(node);
  } else {
    ++frame.zeros;
  }
}

void read_common(ByteReader& in, LinktrackFrame& frame, bool wide_ids) {
  frame.role = in.get<std::uint8_t>();
  frame.id = wide_ids ? in.get<std::uint32_t>() : in.get<std::uint8_t>();
  frame.local_time_ms = in.get<std::uint32_t>();
  frame.system_time_ms = in.get<std::uint32_t>();
  static_cast<void>(in.get<float>());  // voltage
}

void read_nodes(ByteReader& in, LinktrackFrame& frame, bool wide_ids) {
  constexpr std::size_t kNodeBytesMin = 2 + 3 * sizeof(float);
  const std::uint32_t count = in.sequence(kNodeBytesMin);
  for (std::uint32_t i = 0; i < count && in.ok(); ++i) {
    LinktrackNode node;
    node.role = in.get<std::uint8_t>();
    node.id = wide_ids ? in.get<std::uint32_t>() : in.get<std::uint8_t>();
    node.range_m = static_cast<double>(in.get<float>());
    node.fp_rssi_dbm = static_cast<double>(in.get<float>());
    node.rx_rssi_dbm = static_cast<double>(in.get<float>());
    if (in.ok()) add_range(frame, node);
  }
}

LinktrackFrame read_nodeframe2(ByteReader& in, bool with_header) {
  LinktrackFrame frame;
  if (with_header) {
    frame.stamp = in.header().stamp;
    static_cast<void>(in.get<std::int64_t>());  // unix_timestamp
  }
  read_common(in, frame, false);
  // pos, eop, vel, angle, quaternion, gyro, accelerometer of the maker's own fusion: not used
  static_cast<void>(in.get_array<float, 3 * 4 + 4 + 3 * 2>());
  read_nodes(in, frame, false);
  return frame;
}

LinktrackFrame read_tagframe0(ByteReader& in) {
  LinktrackFrame frame;
  read_common(in, frame, false);
  static_cast<void>(in.get_array<float, 3 * 3>());  // pos, eop, vel
  const auto ranges_m = in.get_array<float, 8>();
  static_cast<void>(in.get_array<float, 3 + 4 + 3 * 2>());
  for (std::uint32_t i = 0; i < ranges_m.size() && in.ok(); ++i) {
    LinktrackNode node;
    node.id = i;
    node.range_m = static_cast<double>(ranges_m[i]);
    add_range(frame, node);
  }
  return frame;
}

}  // namespace

Result<LinktrackFrame> decode_linktrack(std::string_view type_name,
                                        std::span<const std::byte> message, Encoding encoding) {
  ByteReader in(message, encoding);
  const auto is = [&](std::string_view name) { return type_name.ends_with(name); };
  LinktrackFrame frame;
  if (is("LinktrackNodeframe2") || is("LinktrackNodeframe2_")) {
    frame = read_nodeframe2(in, false);
    if (!in.ok() || in.remaining() != 0) {
      in = ByteReader(message, encoding);
      frame = read_nodeframe2(in, true);
    }
  } else if (is("LinktrackTagframe0") || is("LinktrackTagframe0_")) {
    frame = read_tagframe0(in);
  } else {
    const bool wide_ids = is("LinktrackNodeframe5") || is("LinktrackNodeframe5_");
    read_common(in, frame, wide_ids);
    read_nodes(in, frame, wide_ids);
  }
  if (!in.ok()) return tl::make_unexpected(in.error(type_name));
  return frame;
}

}  // namespace rali::wire
