#include <algorithm>
#include <utility>

#include "rali/fleet/node/node.hpp"

namespace rali::fleet {

void Node::start_estimate(JobKind kind) {
  estimating_ = UnderWay{kind, ++jobs_, role_.durable.term};
  const bool ends = kind == JobKind::kEndRound;
  out_->emplace_back(RunJob{kind, estimating_->number,
                            mapper_->make_job(ends ? std::optional(sealed_at_) : std::nullopt)});
}

void Node::start_exploration(JobKind kind) {
  exploring_ = UnderWay{kind, ++jobs_, role_.durable.term};
  ExploreInput in;
  in.kind = kind;
  in.placed = mapper_->placed();
  in.fleet = peer_state();
  in.self = self_;
  in.now = now_;
  if (kind == JobKind::kNextAnchor) {
    in.progress_since = progress_since();
    in.forget_points = mapper_->separator().has_value();
  } else {
    in.facts_here = std::all_of(in.fleet.begin(), in.fleet.end(),
                                [](const PeerState& w) { return w.at_rest; }) &&
                    facts_are_here();
  }
  out_->emplace_back(RunJob{kind, exploring_->number, exploration_->make_job(std::move(in))});
}

void Node::cancel_jobs() {
  for (std::optional<UnderWay>* job : {&estimating_, &exploring_}) {
    if (!*job || !(*job)->wanted) continue;
    (*job)->wanted = false;
    out_->emplace_back(CancelJob{(*job)->number});
  }
}

void Node::on(const JobDone& event) {
  if (estimating_ && estimating_->number == event.number) {
    return take_estimate(*std::exchange(estimating_, std::nullopt), event.job.get());
  }
  if (exploring_ && exploring_->number == event.number) {
    take_exploration(*std::exchange(exploring_, std::nullopt), event.job.get());
  }
}

void Node::take_estimate(const UnderWay& job, Job* back) {
  const bool wanted = job.wanted && mapper_ && job.term == role_.durable.term;
  const bool had_place = mapper_ && mapper_->is_placed(self_);
  const JobOutcome outcome = any_mapper()->take_back(back, wanted);
  if (outcome == JobOutcome::kLost) {
    report("fleet.job_lost", Severity::kError,
           "a solution of the map was lost: it is made anew from all facts");
    any_mapper()->restore(all_facts());
  }
  if (!mapper_) return;
  // Frontiers are searched as soon as there is a map.
  if (!had_place) next_look_ = now_;
  const bool taken = outcome == JobOutcome::kTaken;
  if (role_.mode == RoleMode::kSealed && sealing_) {
    // The job cancelled by the seal returns first.
    const bool last = taken && job.kind == JobKind::kEndRound;
    return last ? solved() : start_estimate(JobKind::kEndRound);
  }
  // The cancelled result is missing in the next term.
  if (!taken) next_estimate_ = now_;
  if (taken && may_publish(role_, now_) && !done_) report_map();
}

void Node::take_exploration(const UnderWay& job, Job* back) {
  const bool wanted = job.wanted && mapper_ && job.term == role_.durable.term;
  const JobOutcome outcome = exploration_->take_back(back, wanted);
  if (outcome == JobOutcome::kLost) {
    report("fleet.job_lost", Severity::kError,
           "a search for frontiers was lost: its grid is made anew from all facts");
    exploration_->restore(all_facts());
  }
  if (!mapper_) return;
  const bool taken = outcome == JobOutcome::kTaken;
  if (role_.mode == RoleMode::kSealed && sealing_) {
    if (!sealing_->solved) return;  // the last one starts then
    const bool last = taken && job.kind == JobKind::kNextAnchor;
    return last ? round_ended() : start_exploration(JobKind::kNextAnchor);
  }
  if (!taken) next_look_ = now_;
  if (taken && may_publish(role_, now_) && !done_) send_fleet();
}

/// Without a choice for long the role machine names this vehicle again. The choice waits for the
/// last jobs of the round; a seal blocks no votes, so that may take its time.
void Node::hold_handover() {
  if (role_.mode != RoleMode::kSealed || !sealing_) return;
  if (seconds_between(sealed_at_, now_) >= settings_.roles.round_timeout_s) return;
  constexpr double kLeases = 6.0;  // the role machine's wait after the seal
  const Time until = now_ + Duration::from_s(kLeases * settings_.roles.lease_s);
  role_.handover_until = std::max(role_.handover_until, until);
}

/// Another term began before the round's last jobs returned.
void Node::give_up_seal() {
  if (sealing_) rounds_.anchor_ended(sealing_->why, sealed_at_);
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
