#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "rali/base/time.hpp"
#include "rali/wire/message_kind.hpp"

namespace rali::wire {

/// Adds `shift` to the stamps of a message in CDR in place: headers of clouds, inertial samples,
/// ranges and poses, the time base of Livox clouds, each transform, the header of those LinkTrack
/// frames that have one. Times of points are unchanged: decoders take them as relative to the
/// header if they do not agree with it.
/// @return false: of another kind, without a header, or truncated; nothing was changed
bool shift_stamps(MessageKind kind, std::string_view type_name, Duration shift,
                  std::span<std::byte> cdr);

}  // namespace rali::wire
