#include <algorithm>
#include <utility>

#include "rali/fleet/node/node.hpp"

namespace rali::fleet {

void Node::start_job(JobKind kind) {
  job_ = UnderWay{kind, ++jobs_, role_.durable.term};
  const bool ends = kind == JobKind::kEndRound;
  out_->emplace_back(RunJob{kind, job_->number,
                            survey_->make_job(ends ? std::optional(sealed_at_) : std::nullopt)});
}

void Node::cancel_job() {
  if (!job_ || !job_->wanted) return;
  job_->wanted = false;
  out_->emplace_back(CancelJob{job_->number});
}

void Node::on(const JobDone& event) {
  if (!job_ || job_->number != event.number) return;
  const UnderWay job = *std::exchange(job_, std::nullopt);
  const bool wanted = job.wanted && survey_ && job.term == role_.durable.term;
  const bool had_place = survey_ && survey_->is_placed(self_);
  const Survey::Back back = any_survey()->take_back(event.job.get(), wanted);
  if (back == Survey::Back::kLost) {
    report("fleet.job_lost", Severity::kError,
           "a solution of the map was lost: it is made anew from all facts");
    any_survey()->restore(all_facts());
  }
  if (!survey_) return;
  // Frontiers are looked for as soon as there is a map to look at.
  if (!had_place) next_look_ = now_;
  const bool taken = back == Survey::Back::kTaken;
  if (role_.mode == RoleMode::kSealed && sealing_) {
    if (taken && job.kind == JobKind::kEndRound) return round_ended();
    return start_job(JobKind::kEndRound);
  }
  // What was given up is missing in the term that comes.
  if (!taken) next_estimate_ = now_;
  if (!taken || !may_publish(role_, now_) || done_) return;
  static_cast<void>(survey_->refresh());
  tell_map();
}

/// Without a choice for long the role machine names this vehicle again. The choice waits for the
/// last solution of the round; a seal holds nobody's vote back, so that may take its time.
void Node::hold_handover() {
  if (role_.mode != RoleMode::kSealed || !sealing_) return;
  if (seconds_between(sealed_at_, now_) >= settings_.roles.round_timeout_s) return;
  constexpr double kLeases = 6.0;  // as the role machine waits from the seal on
  const Time until = now_ + Duration::from_s(kLeases * settings_.roles.lease_s);
  role_.handover_until = std::max(role_.handover_until, until);
}

/// Another term began before the round's last solution came.
void Node::give_up_seal() {
  if (sealing_) rounds_.anchor_ended(*sealing_, sealed_at_);
  sealing_.reset();
}

std::vector<FactPtr> Node::all_facts() const {
  std::vector<FactPtr> facts;
  for (const StreamInventory& stream : store_.inventory(0, 0).streams) {
    store_.for_each(stream.stream, 0, stream.end, [&facts](const FactPtr& fact) {
      facts.push_back(fact);
      return true;
    });
  }
  return facts;
}

}  // namespace rali::fleet
