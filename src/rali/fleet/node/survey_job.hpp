#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "rali/fleet/centre/round_centre.hpp"
#include "rali/fleet/facts/fact_store.hpp"
#include "rali/fleet/node/job.hpp"

namespace rali::fleet {

/// What another anchor has left: its boundary, and where it had the keyframes before it.
struct Legacy {
  RoundBoundary boundary;
  std::map<KeyframeId, KeyframePose> keyframes;
};

/// A solution of all that is known. It owns the centre while it is under way, so that nothing has
/// to be copied for it; facts that come meanwhile wait at the Survey.
class SurveyJob final : public Job {
 public:
  void run(Executor& executor, const std::atomic<bool>& cancel) override;

  [[nodiscard]] JobWork work() const override { return work_; }

 private:
  friend class Survey;

  std::unique_ptr<RoundCentre> centre_;
  std::vector<FactPtr> facts_;    ///< that the centre does not have yet
  std::optional<Legacy> legacy_;  ///< likewise
  std::optional<Time> end_round_;
  std::uint64_t generation_ = 0;
  FleetEstimate estimate_;
  bool solved_ = false;
  JobWork work_;
};

}  // namespace rali::fleet
