#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/fleet/rounds/settings.hpp"
#include "rali/map/frontiers.hpp"

namespace rali::fleet {

/// Why a round has ended.
enum class RoundEnd : std::uint8_t {
  kOpen,      ///< it continues
  kFinished,  ///< all tags have finished
  kTimeout,
  kAnchorMoved,  ///< it no longer kept standstill
  kAnchorLost,   ///< another took over without a hand-over
  kExplored,     ///< end of the mission: no frontier is left
  kOperator,
  kEndOfData
};

/// As in rounds.csv: open, finished, timeout, anchor_moved, anchor_lost, explored, operator,
/// end_of_data.
[[nodiscard]] std::string_view name_of(RoundEnd end);

/// As in status and frontiers.csv: none, signal, distance, explored, range_lost, sigma,
/// unreachable, battery, timeout, operator.
[[nodiscard]] std::string_view name_of(FinishReason reason);

/// One line of rounds.csv (product.md 5).
struct RoundRow {
  std::uint32_t round = 0;  ///< from 1
  VehicleId anchor;
  Time start;
  std::optional<Time> end;  ///< none: it continues
  RoundEnd ended_by = RoundEnd::kOpen;
  std::optional<VehicleId> next_anchor;
  std::optional<std::uint32_t> frontier;  ///< that decided the choice of the next anchor

  bool operator==(const RoundRow&) const = default;
};

/// One line of frontiers.csv: a frontier at the end of its round.
struct FrontierRow {
  std::uint32_t round = 0;
  std::uint32_t id = 0;
  double x_m = 0.0, y_m = 0.0, length_m = 0.0;
  std::optional<VehicleId> nearest_vehicle;
  map::FrontierState state = map::FrontierState::kOpen;
  std::string reason;  ///< a sentence without a full stop
  bool tried = false;  ///< map::FrontierArea::tried

  bool operator==(const FrontierRow&) const = default;
};

[[nodiscard]] std::string_view name_of(map::FrontierState state);

/// State of a mission's rounds as any vehicle can derive it from received messages: the round, its
/// anchor, who has finished and why, the next anchor, and the end of the mission (algorithms_fleet
/// 10.4). It decides nothing about roles: RoleMachine does.
class RoundMachine {
 public:
  explicit RoundMachine(const RoundSettings& settings) : settings_(settings) {}

  /// A vehicle is anchor (commit received, or own). The same anchor in a new term is no new round;
  /// a round that was open ends by kAnchorLost.
  void anchor_began(VehicleId anchor, Time t, bool new_round = true);
  /// A tag has finished, or (kNone) continues after all.
  void tag_finished(VehicleId vehicle, FinishReason reason);
  /// The anchor has sealed.
  void anchor_ended(RoundEnd why, Time t);
  /// Named in a hand-over.
  void next_chosen(VehicleId next, std::optional<std::uint32_t> frontier);
  /// The frontiers of the merged map, identified by map::FrontierBook; `vehicles[k]` is the vehicle
  /// of FrontierArea::nearest = k. `facts_agree`: all inventories are equal, so that no frontier is
  /// missing for lack of keyframes.
  void frontiers_seen(std::span<const map::FrontierArea> frontiers,
                      std::span<const VehicleId> vehicles, bool facts_agree);
  /// An open frontier of the last look at the end of the mission: why the vehicles did not reach
  /// it.
  void frontier_stopped(std::uint32_t frontier, std::string why);
  /// No more data: closes the open round.
  void end_of_data(Time t);

  [[nodiscard]] std::uint32_t round() const {
    return static_cast<std::uint32_t>(rows_.size());
  }  ///< 0 before the first

  [[nodiscard]] std::optional<VehicleId> anchor() const;  ///< of the open round
  /// Why a vehicle has finished in this round; kNone: it has not.
  [[nodiscard]] FinishReason finished(VehicleId vehicle) const;

  /// No open frontier in `evaluations` consecutive looks, while all facts were present.
  [[nodiscard]] bool mission_over() const;

  [[nodiscard]] const std::vector<RoundRow>& rounds() const { return rows_; }

  [[nodiscard]] const std::vector<FrontierRow>& frontiers() const { return frontier_rows_; }

 private:
  void close(RoundEnd why, Time t);

  struct Done {
    VehicleId vehicle;
    FinishReason reason = FinishReason::kNone;
  };

  RoundSettings settings_;
  std::vector<RoundRow> rows_;
  std::vector<FrontierRow> frontier_rows_;
  std::vector<Done> finished_;
  std::vector<FrontierRow> seen_;  ///< at the last look
  std::vector<FrontierRow> gone_;  ///< open earlier in this round, not any more
  double looks_without_ = 0.0;
};

/// An interval in which a vehicle was at standstill.
struct Stand {
  VehicleId vehicle;
  Time start, end;

  bool operator==(const Stand&) const = default;
};

/// Finds the standstills of one vehicle of at least stand_min_s in its at-rest marks, fed by time.
class StandFinder {
 public:
  StandFinder(VehicleId vehicle, double stand_min_s)
      : vehicle_(vehicle), stand_min_s_(stand_min_s) {}

  /// Marks older than the last, and gaps above 2 s, end a standstill: the state meanwhile is
  /// unknown.
  void add(Time t, bool at_rest);
  /// All standstills so far, the current one included if it is long enough.
  [[nodiscard]] std::vector<Stand> stands() const;

 private:
  void close();

  VehicleId vehicle_;
  double stand_min_s_;
  std::optional<Time> since_;
  Time last_;
  std::vector<Stand> stands_;
};

/// Rounds of a recording that was not made in rounds (algorithms_fleet 10.6): a vehicle at
/// standstill is anchor; of several the one with the longest standstill, until it leaves.
/// Standstills may overlap and come in any order; those shorter than stand_min_s are left out.
/// Times without anchor have no round.
[[nodiscard]] std::vector<RoundRow> rounds_of_stands(std::span<const Stand> stands,
                                                     double stand_min_s);

/// Rounds from the user's table (fleet.yaml `rounds: FILE`): a row is (anchor, start, end). Errors
/// (kInput), with the number of the row, counted from 1: an interval that ends before it starts, or
/// starts before the previous one has ended.
[[nodiscard]] Result<std::vector<RoundRow>> rounds_of_table(std::span<const Stand> table);

}  // namespace rali::fleet
