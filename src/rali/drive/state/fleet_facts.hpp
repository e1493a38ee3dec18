#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/fleet/facts/fact_store.hpp"

namespace rali::drive {

/// What state folders hold of a mission (docs/reference/state.md), as one set of facts: whoever
/// was told a fact has the same one.
struct FleetFacts {
  struct Member {
    std::string name;  ///< as it named itself at its last start; "vehicle_3" where no fact says so
    bool named = false;  ///< by itself
    std::vector<geometry::Vec3> antennas_body_m;
    std::vector<fleet::FactPtr> facts;  ///< by epoch and number; may be empty
    std::size_t missing = 0;  ///< facts below the last one of each start that no folder holds
  };

  std::vector<Member> members;       ///< by number of the vehicle
  std::vector<std::string> folders;  ///< by name, each once
  FindingList findings;              ///< damage
};

/// Whether a folder holds what `rali run --state` writes.
[[nodiscard]] bool is_state_folder(const std::string& path);

/// Reads state folders and changes nothing in them; their vehicles may be running. The same for any
/// order of the folders.
/// Errors: kInput for what is no state folder, holds no fact, was written by a newer program, or
/// contradicts another one: two missions, or two fleets; kMachine.
[[nodiscard]] Result<FleetFacts> read_fleet_facts(std::vector<std::string> folders);

}  // namespace rali::drive
