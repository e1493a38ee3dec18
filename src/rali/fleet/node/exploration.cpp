#include "rali/fleet/node/exploration.hpp"

#include <utility>

#include "rali/base/assert.hpp"

namespace rali::fleet {

std::shared_ptr<Job> Exploration::make_job(ExploreInput in) {
  RALI_ASSERT(map_ != nullptr);
  auto job = std::make_shared<ExploreJob>(dispatcher_, settings_.place_m);
  job->map_ = std::move(map_);
  job->facts_ = std::exchange(waiting_, {});
  job->in_ = std::move(in);
  return job;
}

JobOutcome Exploration::take_back(Job* job, bool wanted) {
  auto* back = dynamic_cast<ExploreJob*>(job);
  if (back == nullptr || back->map_ == nullptr) return JobOutcome::kLost;
  map_ = std::move(back->map_);
  // Facts of a job that never ran.
  waiting_.insert(waiting_.begin(), back->facts_.begin(), back->facts_.end());
  if (!wanted || !back->ended_) return JobOutcome::kDropped;
  dispatcher_ = std::move(back->dispatcher_);
  input_ = std::move(back->in_);
  result_ = std::move(back->result_);
  return JobOutcome::kTaken;
}

void Exploration::restore(std::vector<FactPtr> facts) {
  map_ = std::make_unique<ExploreMap>(settings_.explore);
  waiting_ = std::move(facts);
}

}  // namespace rali::fleet
