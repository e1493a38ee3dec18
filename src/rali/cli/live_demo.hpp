#pragma once

#include <string>
#include <vector>

#include "rali/cli/session.hpp"

namespace rali::cli {

struct LiveDemo {
  std::string folder;
  std::string scene = "floor";
  std::string seed = "1";
  std::string duration_s = "0";  ///< of the world; 0: until everything is explored
  int vehicles = 3;
  int port = 8765;  ///< of v1's page; those of the others follow
};

/// A world and one `rali run` for each vehicle, all on this machine, until the fleet has explored
/// the world, its time is over or Ctrl-C asks to end. Then folder/recording holds what the sensors
/// sent, with the truth, and folder/mission/live the poses as they were published.
/// @return false: it was ended before time. Errors: kMachine (a process does not start or ends with
/// an error: its last lines).
[[nodiscard]] Result<bool> run_live_demo(const LiveDemo& demo, Session& session);

}  // namespace rali::cli
