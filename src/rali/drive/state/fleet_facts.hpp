#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/fleet/facts/fact_store.hpp"

namespace rali::drive {

/// The contents of state folders of a mission (docs/reference/state.md), as one set of facts: all
/// copies of a fact are identical.
struct FleetFacts {
  struct Member {
    std::string name;    ///< from its last start; "vehicle_3" if no fact names it
    bool named = false;  ///< by its own fact
    std::vector<geometry::Vec3> antennas_body_m;
    std::vector<fleet::FactPtr> facts;  ///< by epoch and number; may be empty
    std::size_t missing = 0;  ///< facts below the last one of each start that no folder holds
  };

  std::vector<Member> members;       ///< by number of the vehicle
  std::vector<std::string> folders;  ///< by name, each once
  FindingList findings;              ///< damage
};

/// Whether a folder was written by `rali run --state`.
[[nodiscard]] bool is_state_folder(const std::string& path);

/// Reads state folders and changes nothing in them; their vehicles may be running. The result does
/// not depend on the order of the folders.
/// Errors: kInput for a folder that is no state folder, holds no fact, was written by a newer
/// program, or contradicts another one: two missions, or two fleets; kMachine.
[[nodiscard]] Result<FleetFacts> read_fleet_facts(std::vector<std::string> folders);

}  // namespace rali::drive
