#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/config/load_fleet.hpp"
#include "rali/drive/state/fleet_facts.hpp"

namespace rali::jobs {

/// What a map is made from.
struct MapInputs {
  config::FleetConfig fleet;
  /// What state folders hold, vehicle by vehicle as `fleet` has them; null: recordings.
  std::shared_ptr<const drive::FleetFacts> facts;
};

/// The fleet that the inputs of a mapping run describe: one fleet.yaml, or recordings, one vehicle
/// each; or state folders of a live fleet, and its fleet.yaml beside them if there is one.
/// Errors: as config::load_fleet and drive::read_fleet_facts; kUsage for a fleet.yaml among
/// recordings, for inputs of two kinds, for state folders of another fleet than fleet.yaml names.
[[nodiscard]] Result<MapInputs> load_inputs(const std::vector<std::string>& inputs,
                                            const config::Overrides& overrides);

/// Formats in which the map can be written: pcd, ply, las.
/// @param where the option or key that names the format, for the message. Errors: kUsage.
[[nodiscard]] Status check_format(const std::string& format, const std::string& where);

}  // namespace rali::jobs
