#pragma once

#include <string>
#include <vector>

#include "rali/cli/session.hpp"

namespace rali::cli {

struct LiveDemo {
  std::string folder;
  std::string scene = "floor";
  std::string seed = "1";
  std::string duration_s = "0";  ///< of simulated time; 0: until everything is explored
  int vehicles = 3;
  int port = 8765;  ///< of v1's page; the others use the following ports
};

/// Runs a simulated world and one `rali run` per vehicle on this machine. Ends when the fleet has
/// explored the world, at the time limit or on Ctrl-C. Then folder/recording holds the sensor data
/// and the ground truth, and folder/mission/live the poses as published.
/// @return false: it was interrupted. Errors: kMachine (a process does not start or ends with
/// an error: its last log lines).
[[nodiscard]] Result<bool> run_live_demo(const LiveDemo& demo, Session& session);

}  // namespace rali::cli
