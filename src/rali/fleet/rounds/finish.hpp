#pragma once

#include <deque>
#include <limits>
#include <optional>
#include <utility>

#include "rali/base/time.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/fleet/rounds/settings.hpp"

namespace rali::fleet {

/// What a tag knows at a time; any rate will do, 1 Hz is enough.
struct FinishInput {
  Time t;
  std::optional<double> rssi_dbm;    ///< heard from the anchor since the last input
  std::optional<double> range_m;     ///< accepted range to the anchor since then
  std::optional<double> distance_m;  ///< to the anchor, from the estimates
  /// Since the round began: a new anchor may stand as far ahead as the old one's limit. Distance
  /// and radio do not count yet; ranges are heard all the same.
  bool comes_from_afar = false;
  std::optional<bool> frontier_left;  ///< a reachable one of its own; none: not looked yet
  bool frontier_beyond = false;       ///< one that nobody is on the way to: it has no way there
  bool moves = false;
  bool blind = false;    ///< the LiDAR does not tell a direction of travel here
  double sigma_m = 0.0;  ///< of its place
  std::optional<double> battery_share;
  bool timeout = false;
  bool operator_stop = false;
};

/// The vehicle stands even where a goal is left, unlike one that has only seen its surroundings.
[[nodiscard]] bool forbids_driving(FinishReason reason);

struct FinishView {
  FinishReason reason = FinishReason::kNone;  ///< other than kNone: stop, stand, tell the anchor
  bool latched = false;                       ///< stays until the next round
  bool warn = false;                          ///< no goals further away from the anchor
  bool drive_back = false;                    ///< up to 3 m, to find the ranges again
};

/// When a tag has finished its part of the round (algorithms_fleet 10.1; paper "System
/// Definition"): radio too weak, anchor too far, or surroundings explored; `robust` adds ranges
/// lost in a blind stretch, an unsure place, battery. Radio and distance are latched:
/// a vehicle at the edge must not start and stop. An unsure place is one that has become so in this
/// round: in a long tunnel sigma grows from stand to stand, and standing does not lessen it; and
/// not beside the anchor, where ranges tell nothing of the way: who stops there stays unsure, who
/// goes on is held by them again. Explored, lost and unsure clear again; so does unreachable as the
/// other name of explored: frontiers are left, but none to which it gets.
class FinishWatch {
 public:
  explicit FinishWatch(const FinishSettings& settings) : settings_(settings) {}

  /// Forgets all latches and what was measured to the old anchor.
  void new_round(Time t);

  /// Inputs of a time before the last are left out. Values that are not numbers count as missing.
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
  std::optional<Time> unheard_since_;  ///< blind, moving, without a range
  std::optional<Time> back_since_;     ///< drives back since
  bool unsure_ = false;
  double least_sigma_m_ = std::numeric_limits<double>::infinity();  ///< in this round
  bool beyond_ = false;                                             ///< at the last look
  FinishReason latch_ = FinishReason::kNone;
};

}  // namespace rali::fleet
