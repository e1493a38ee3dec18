#pragma once

namespace rali::report {

/// Of one kind about one vehicle, on the page and on the terminal: twenty of one kind hide the
/// others.
inline constexpr int kFindingsShownMax = 3;

}  // namespace rali::report
