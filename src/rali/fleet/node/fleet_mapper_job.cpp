#include "rali/fleet/node/fleet_mapper_job.hpp"

#include <utility>

namespace rali::fleet {

void FleetMapperJob::run(Executor& executor, const std::atomic<bool>& cancel) {
  const StopFlag stop(cancel);
  for (const FactPtr& fact : std::exchange(facts_, {})) centre_->add(fact);
  if (legacy_) static_cast<void>(centre_->take_over(legacy_->separator, legacy_->keyframes));
  legacy_.reset();
  const RoundCentre::Work before = centre_->work();
  if (end_round_) {
    centre_->end_round(*end_round_, executor, stop);
  } else {
    centre_->estimate(executor, stop);
  }
  const RoundCentre::Work& after = centre_->work();
  work_ = {after.all_nodes - before.all_nodes, after.cut - before.cut,
           after.compared - before.compared};
  if (stop.raised()) return;
  if (end_round_) centre_->forget_finished_points();
  estimate_ = centre_->last();
  solved_ = true;
}

}  // namespace rali::fleet
