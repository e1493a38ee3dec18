#pragma once

namespace rali::wire {

/// Serialisation format of a message.
enum class Encoding { kRos1, kCdr, kOther };

}  // namespace rali::wire
