#pragma once

#include <deque>
#include <limits>
#include <optional>
#include <utility>

#include "rali/base/time.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/fleet/rounds/settings.hpp"

namespace rali::fleet {

/// Input of a tag at a time; any rate will do, 1 Hz is enough.
struct FinishInput {
  Time t;
  std::optional<double> rssi_dbm;    ///< received from the anchor since the last input
  std::optional<double> range_m;     ///< accepted range to the anchor since then
  std::optional<double> distance_m;  ///< to the anchor, from the estimates
  /// True since the start of the round: a new anchor may be as far ahead as the old one's limit.
  /// Distance and radio do not count yet; ranges are processed all the same.
  bool comes_from_afar = false;
  std::optional<bool> frontier_left;  ///< a reachable one of its own; none: not evaluated yet
  bool frontier_beyond = false;       ///< one that no vehicle is driving to: it has no path there
  bool moves = false;
  bool degenerate = false;  ///< a direction of travel is unobservable to the LiDAR here
  double sigma_m = 0.0;     ///< of its position
  std::optional<double> battery_fraction;
  bool timeout = false;
  bool operator_stop = false;
};

/// The vehicle stops even if a goal is left, unlike one that has only explored its surroundings.
[[nodiscard]] bool forbids_driving(FinishReason reason);

struct FinishView {
  FinishReason reason = FinishReason::kNone;  ///< other than kNone: stop, keep standstill, inform
                                              ///< the anchor
  bool latched = false;                       ///< stays until the next round
  bool warn = false;                          ///< no goals farther from the anchor
  bool drive_back = false;                    ///< up to 3 m, to receive ranges again
};

/// Decides when a tag has finished its part of the round (algorithms_fleet 10.1; paper "System
/// Definition"): radio too weak, anchor too far, or surroundings explored; `robust` adds ranges
/// lost in a degenerate stretch, a large position sigma, battery. Radio and distance are latched,
/// so that a vehicle at the limit does not start and stop. The sigma must have grown within this
/// round: in a long tunnel it grows from stop to stop, and standstill does not reduce it. The sigma
/// also does not count near the anchor, where ranges do not constrain the direction of travel: a
/// vehicle that stops there keeps its sigma, one that drives on is constrained again. Explored,
/// lost and sigma clear again. So does unreachable, which replaces explored if frontiers are left
/// that it cannot reach.
class FinishWatch {
 public:
  explicit FinishWatch(const FinishSettings& settings) : settings_(settings) {}

  /// Clears all latches and the measurements to the old anchor.
  void new_round(Time t);

  /// Distance to the anchor: the newest range, or by the estimates if that is old. Around a corner
  /// the range is longer, and so is the path of the radio.
  [[nodiscard]] std::optional<double> apart_m(const FinishInput& input) const;

  /// Inputs older than the last are ignored. Values that are not numbers count as missing.
  FinishView step(const FinishInput& input);

 private:
  void take_radio(const FinishInput& input);
  void take_range(const FinishInput& input);
  [[nodiscard]] std::optional<double> rssi_median_dbm() const;
  [[nodiscard]] std::optional<double> distance_m(const FinishInput& input) const;
  [[nodiscard]] FinishReason latching(const FinishInput& input);
  [[nodiscard]] FinishReason clearing(const FinishInput& input, FinishView& view);
  [[nodiscard]] bool is_unsure(const FinishInput& input);
  [[nodiscard]] bool ranges_are_lost(const FinishInput& input, FinishView& view);

  FinishSettings settings_;
  Time last_;
  bool has_time_ = false;
  std::deque<std::pair<Time, double>> rssi_dbm_;
  std::optional<std::pair<Time, double>> range_m_;
  std::optional<Time> explored_since_;
  std::optional<Time> unheard_since_;  ///< degenerate, moving, without a range
  std::optional<Time> back_since_;     ///< start of driving back
  bool unsure_ = false;
  double min_sigma_m_ = std::numeric_limits<double>::infinity();  ///< in this round
  bool beyond_ = false;                                           ///< at the last evaluation
  FinishReason latch_ = FinishReason::kNone;
};

}  // namespace rali::fleet
