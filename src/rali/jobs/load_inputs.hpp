#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/config/load_fleet.hpp"
#include "rali/drive/state/fleet_facts.hpp"

namespace rali::jobs {

/// The inputs of a map.
struct MapInputs {
  config::FleetConfig fleet;
  /// The contents of state folders, in the order of the vehicles in `fleet`; null: recordings.
  std::shared_ptr<const drive::FleetFacts> facts;
};

/// The fleet described by the inputs of a mapping run: one fleet.yaml, or recordings, one vehicle
/// each; or state folders of a live fleet, with an optional fleet.yaml. Errors: as
/// config::load_fleet and drive::read_fleet_facts; kUsage for a fleet.yaml among recordings, for
/// inputs of two kinds, for state folders of another fleet than in fleet.yaml.
[[nodiscard]] Result<MapInputs> load_inputs(const std::vector<std::string>& inputs,
                                            const config::Overrides& overrides);

/// Formats in which the map can be written: pcd, ply, las.
/// @param where the option or key that names the format, for the message. Errors: kUsage.
[[nodiscard]] Status check_format(const std::string& format, const std::string& where);

}  // namespace rali::jobs
