#include "rali/fleet/centre/centre.hpp"

#include <utility>

#include "rali/fleet/centre/solution.hpp"

namespace rali::fleet {

Centre::Centre(const FleetSettings& settings, FleetKnowledge knowledge)
    : settings_(settings), knowledge_(std::move(knowledge)) {}

FleetEstimate Centre::estimate(Executor& executor, ComparedPieces* compared, StopFlag stop) const {
  SolutionInput in{.paths = paths(), .knowledge = knowledge_, .settings = settings_};
  in.compared = compared;
  in.stop = stop;
  return solve_fleet(std::move(in), executor).estimate;
}

}  // namespace rali::fleet
