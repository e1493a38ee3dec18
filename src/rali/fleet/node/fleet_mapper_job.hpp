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

/// What another anchor leaves: its separator prior, and its poses of the keyframes before it.
struct Legacy {
  SeparatorPrior separator;
  std::map<KeyframeId, KeyframePose> keyframes;
};

/// A solution of all known facts. It owns the centre while it runs, so that nothing must be copied;
/// facts that arrive meanwhile wait in the FleetMapper.
class FleetMapperJob final : public Job {
 public:
  void run(Executor& executor, const std::atomic<bool>& cancel) override;

  [[nodiscard]] JobWork work() const override { return work_; }

 private:
  friend class FleetMapper;

  std::unique_ptr<RoundCentre> centre_;
  std::vector<FactPtr> facts_;    ///< not added to the centre yet
  std::optional<Legacy> legacy_;  ///< likewise
  std::optional<Time> end_round_;
  std::uint64_t generation_ = 0;
  FleetEstimate estimate_;
  bool solved_ = false;
  JobWork work_;
};

}  // namespace rali::fleet
