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

/// What one vehicle of a recording told.
struct ToldByVehicle {
  VehicleId vehicle;
  std::span<const std::shared_ptr<const fleet::Fact>> facts;
  Time data_end;        ///< its last sweep
  double rest_s = 5.0;  ///< PathSettings::rest_s
};

/// When the rounds of a recording end, ascending: by the table, or by who stood when. The end of
/// the last one is not told: what follows belongs to it.
[[nodiscard]] std::vector<Time> round_ends(std::span<const ToldByVehicle> vehicles,
                                           const RoundsJob& job);

/// Gives the centre all facts as they would have come over the mission, and ends its rounds.
/// @param ended called with each round's end; may be empty
/// @return the estimate when all is over
fleet::FleetEstimate estimate_by_rounds(std::span<const ToldByVehicle> vehicles,
                                        std::span<const Time> ends, fleet::RoundCentre& centre,
                                        Executor& executor,
                                        const std::function<void(Time)>& ended = {});

/// The facts of all vehicles as one estimate; by rounds, if the settings want it.
[[nodiscard]] fleet::FleetEstimate estimate_facts(std::span<const ToldByVehicle> vehicles,
                                                  const MapJob& job, Executor& executor);

/// The same of all vehicles of a run.
[[nodiscard]] fleet::FleetEstimate estimate_fleet(const std::vector<VehicleRun>& runs,
                                                  const MapJob& job, Executor& executor);

}  // namespace rali::drive
