#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/drive/map_run.hpp"
#include "rali/drive/output/rounds_input.hpp"
#include "rali/drive/vehicle_run.hpp"
#include "rali/fleet/centre/round_centre.hpp"

namespace rali::drive {

/// The facts that one vehicle of a recording reported.
struct ReportedByVehicle {
  VehicleId vehicle;
  std::span<const std::shared_ptr<const fleet::Fact>> facts;
  Time data_end;        ///< its last scan
  double rest_s = 5.0;  ///< PathSettings::rest_s
};

/// When the rounds of a recording end, ascending: by the table, or by the standstills of the
/// vehicles. The end of the last round is left out: all later data belong to it.
[[nodiscard]] std::vector<Time> round_ends(std::span<const ReportedByVehicle> vehicles,
                                           const RoundsJob& job);

/// Gives the centre all facts in the order of the mission, and ends its rounds.
/// @param ended called with each round's end; may be empty
/// @return the estimate after the last round
fleet::FleetEstimate estimate_by_rounds(std::span<const ReportedByVehicle> vehicles,
                                        std::span<const Time> ends, fleet::RoundCentre& centre,
                                        Executor& executor,
                                        const std::function<void(Time)>& ended = {});

/// The joint estimate from the facts of all vehicles; by rounds, if the settings say so.
[[nodiscard]] fleet::FleetEstimate estimate_facts(std::span<const ReportedByVehicle> vehicles,
                                                  const MapJob& job, Executor& executor);

/// The same for all vehicles of a run.
[[nodiscard]] fleet::FleetEstimate estimate_fleet(const std::vector<VehicleRun>& runs,
                                                  const MapJob& job, Executor& executor);

}  // namespace rali::drive
