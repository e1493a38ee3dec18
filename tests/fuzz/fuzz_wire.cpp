// Any bytes as any message: no decoder may crash, hang or allocate more than the message justifies.
// First byte: encoding and type; the rest is the message.
#include <cstddef>
#include <cstdint>

#include "rali/wire/decode.hpp"
#include "rali/wire/encode.hpp"

namespace {

using namespace rali::wire;

// A decoded message must be encodable, too.
template <class T>
void write_again(const rali::Result<T>& value, Encoding encoding) {
  if (value) static_cast<void>(encode(*value, encoding));
}

void decode_as(unsigned kind, std::span<const std::byte> message, Encoding encoding) {
  switch (kind) {
    case 0:
      return write_again(decode_point_cloud2(message, encoding), encoding);
    case 1:
      return write_again(decode_livox_custom(message, encoding), encoding);
    case 2:
      return write_again(decode_imu(message, encoding), encoding);
    case 3:
      return write_again(decode_tf(message, encoding), encoding);
    case 4:
      return write_again(decode_pose_stamped(message, encoding), encoding);
    case 5:
      return write_again(decode_range(message, encoding), encoding);
    case 6:
      static_cast<void>(decode_odometry(message, encoding));
      return;
    case 7:
      static_cast<void>(decode_linktrack("nlink_parser/LinktrackNodeframe2", message, encoding));
      return;
    case 8:
      static_cast<void>(decode_linktrack("nlink_parser/LinktrackNodeframe3", message, encoding));
      return;
    case 9:
      static_cast<void>(decode_linktrack("nlink_parser/LinktrackNodeframe5", message, encoding));
      return;
    default:
      static_cast<void>(decode_linktrack("nlink_parser/LinktrackTagframe0", message, encoding));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const Encoding encoding = (data[0] & 0x80U) != 0 ? Encoding::kCdr : Encoding::kRos1;
  decode_as((data[0] & 0x7FU) % 11, std::as_bytes(std::span(data + 1, size - 1)), encoding);
  static_cast<void>(message_kind(std::string_view(reinterpret_cast<const char*>(data), size)));
  return 0;
}
