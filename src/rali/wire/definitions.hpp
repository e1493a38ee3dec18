#pragma once

#include <string>
#include <string_view>

#include "rali/wire/encoding.hpp"

namespace rali::wire {

/// Definition text of a message with those of the messages it contains, in the form of bag
/// connections (kRos1) and MCAP schemas (kCdr: "ros2msg"). The type may be named in either style.
/// Empty for types that RaLI does not write.
[[nodiscard]] std::string message_definition(std::string_view type_name, Encoding encoding);

/// The md5sum that ROS 1 compares; empty for types that RaLI does not write.
[[nodiscard]] std::string_view message_md5(std::string_view type_name);

}  // namespace rali::wire
