#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/drive/output/final_path.hpp"
#include "rali/drive/output/rounds_input.hpp"
#include "rali/drive/vehicle_run.hpp"
#include "rali/fleet/facts/facts.hpp"

namespace rali::drive {

/// A fleet's run with final poses. Everything referred to must outlive the object.
struct FleetRunView {
  const std::vector<VehicleRun>* runs = nullptr;  ///< by vehicle
  std::vector<const VehicleRun*> mapped;          ///< those that share the frame of map.*
  std::string out_dir;

  [[nodiscard]] VehicleId id_of(const VehicleRun& run) const {
    return {static_cast<std::uint16_t>(&run - runs->data())};
  }
};

/// The vehicles of the largest group that has a map.
[[nodiscard]] std::vector<const VehicleRun*> mapped_runs(const std::vector<VehicleRun>& runs,
                                                         const fleet::FleetEstimate& estimate);

/// Passes the keyframes of the vehicles that share a frame to `visit`, by time, equal times by
/// vehicle; diverged ones are left out. Errors: kMachine.
using KeyframeByTime = std::function<Status(KeyframeId id, const map::KeyframeView& keyframe)>;
[[nodiscard]] Status walk_keyframes(const FleetRunView& fleet, const KeyframeByTime& visit);

/// The rounds of a run and their frontiers.
struct FleetRounds {
  std::vector<fleet::RoundRow> rounds;
  /// As they were at the end of their round; round 0: at the end of the data, if that is later than
  /// the last round.
  std::vector<fleet::FrontierRow> frontiers;
};

/// Standstill intervals of a vehicle, from the standstill flags at the nodes of its path. Nodes of
/// a standing vehicle are up to rest_s apart, and a node is added when it moves off.
/// @param data_end its last scan
[[nodiscard]] std::vector<fleet::Stand> stands_of(
    VehicleId vehicle, std::span<const std::shared_ptr<const fleet::Fact>> facts, Time data_end,
    double rest_s, double stand_min_s);

/// Determines why rounds found by standstills ended: end_of_data if the anchor stood to the end of
/// its data; finished if every other vehicle had finished by then (algorithms_fleet 10.1: radio,
/// distance, lost ranges, uncertainty; by the settings), so that the anchor had nobody to wait for;
/// else the anchor just moved.
void judge_ends(const FleetRunView& fleet, const RoundsJob& job,
                std::vector<fleet::RoundRow>& rounds);

/// Finds the rounds and searches for frontiers at the end of each, in the map as known then, with
/// its final poses. The deciding frontier is the largest one if the paper's rule selects the next
/// anchor (10.3). `rest_s`: PathSettings::rest_s of each vehicle. Errors: kMachine.
[[nodiscard]] Result<FleetRounds> find_rounds(const FleetRunView& fleet, const RoundsJob& job,
                                              std::span<const double> rest_s,
                                              FindingList& findings);

/// rounds.csv and frontiers.csv. Errors: kMachine.
[[nodiscard]] Status write_rounds_files(const FleetRunView& fleet, const FleetRounds& rounds);

}  // namespace rali::drive
