#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "rali/ranging/peer_fit.hpp"

namespace rali::ranging {

/// A stretch in which one of two vehicles stands while the other may move.
struct StandWindow {
  Track track;                     ///< of the antenna that may move, by the clock of its vehicle
  std::vector<TimedRange> ranges;  ///< by time, with their own stamps
};

/// By how much the stamps of ranges are ahead of a track's clock.
struct StampOffset {
  double value_s = 0.0, sigma_s = 0.0;
  double residual_m = 0.0;  ///< root mean square after the fit
  std::size_t ranges = 0;
};

/// Why no offset is given.
enum class NoOffset {
  kTooLittle,  ///< too few ranges whose time is on the track for all offsets
  kNoMotion,   ///< the ranges fit for many offsets: no change of speed or direction
  kSeveral,    ///< several offsets fit alike
  kBeyond      ///< the best one is at the limit of the search
};

/// The offset, within half_s, for which the ranges fit the motion. Only changes of the distance
/// determine it: a vehicle that starts, stops or passes by. The standing antenna is estimated in
/// each window, with the pair's bias. sigma covers what the windows disagree by, the latency of the
/// ranges is part of the offset.
/// @param unknown receives the reason if there is none
[[nodiscard]] std::optional<StampOffset> find_stamp_offset(std::span<const StandWindow> windows,
                                                           double half_s,
                                                           NoOffset* unknown = nullptr);

}  // namespace rali::ranging
