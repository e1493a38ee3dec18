#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "rali/base/result.hpp"
#include "rali/wire/cloud_format.hpp"
#include "rali/wire/encoding.hpp"
#include "rali/wire/message_kind.hpp"
#include "rali/wire/messages.hpp"

/// Decodes the bytes of one message. All refuse truncated or contradictory bytes with an Error
/// (kInput) whose `where` is the byte in the message; bytes after the last field are ignored, as in
/// ROS. Spans in the results point into `message`.
namespace rali::wire {

/// sensor_msgs/PointCloud2. The layout (offsets, steps, types) is checked only by
/// decide_cloud_format and decode_cloud, so that `rali info` can show its faults.
[[nodiscard]] Result<CloudView> decode_point_cloud2(std::span<const std::byte> message,
                                                    Encoding encoding);

/// Livox CustomMsg of any driver generation, as a CloudView with fields offset_time (uint32 ns
/// after the stamp), x, y, z, reflectivity, tag, line. The stamp is the header's, or the time base
/// if the header has none.
[[nodiscard]] Result<CloudView> decode_livox_custom(std::span<const std::byte> message,
                                                    Encoding encoding);

/// A cloud topic's message of kind kPointCloud2 or kLivoxCustom.
[[nodiscard]] Result<CloudView> decode_cloud_message(MessageKind kind,
                                                     std::span<const std::byte> message,
                                                     Encoding encoding);

[[nodiscard]] Result<ImuMessage> decode_imu(std::span<const std::byte> message, Encoding encoding);

/// Transforms with a zero quaternion are left out and counted, others are normalised.
[[nodiscard]] Result<TfMessage> decode_tf(std::span<const std::byte> message, Encoding encoding);

[[nodiscard]] Result<PoseStamped> decode_pose_stamped(std::span<const std::byte> message,
                                                      Encoding encoding);

[[nodiscard]] Result<Odometry> decode_odometry(std::span<const std::byte> message,
                                               Encoding encoding);

/// @param type_name selects the frame type (Nodeframe2, 3, 5, Tagframe0).
[[nodiscard]] Result<LinktrackFrame> decode_linktrack(std::string_view type_name,
                                                      std::span<const std::byte> message,
                                                      Encoding encoding);

[[nodiscard]] Result<RangeMessage> decode_range(std::span<const std::byte> message,
                                                Encoding encoding);

}  // namespace rali::wire
