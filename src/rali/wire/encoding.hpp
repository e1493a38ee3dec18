#pragma once

namespace rali::wire {

/// How a message's bytes are laid out.
enum class Encoding { kRos1, kCdr, kOther };

}  // namespace rali::wire
