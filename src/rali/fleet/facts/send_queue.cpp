#include "rali/fleet/facts/send_queue.hpp"

#include <algorithm>

#include "rali/fleet/facts/quantise.hpp"
#include "rali/fleet/messages/kind.hpp"

namespace rali::fleet {

namespace {

/// Limit of memory: beyond it a link's rate is evaluated from a part of what was sent.
constexpr std::size_t kUnconfirmedMax = 10000;
/// With fewer bytes a link would appear full or empty by chance.
constexpr std::size_t kJudgedBytesMin = 4000;
/// Fraction that arrived: below it a full link loses because of its rate, not because of the radio.
constexpr double kCameFractionMin = 0.5;
constexpr double kRateGrowth = 1.5;
constexpr double kBurst_s = 0.5;
/// A larger fact is sent as well, and the facts after it wait longer.
constexpr double kBurstMin_bytes = 3000.0;

int class_of(const Fact& fact) {
  switch (kind_of(fact)) {
    case Kind::kLoop:
      return 1;
    case Kind::kCoarsePoints:
      return 2;
    case Kind::kFinePoints:
      return 3;
    default:
      return 0;
  }
}

bool holds(const Holdings& holdings, const FactKey& key) {
  const auto stream = holdings.find({key.vehicle, key.epoch});
  return stream != holdings.end() && stream->second.contains(key.seq);
}

}  // namespace

SendQueue::SendQueue(const ExchangeSettings& settings)
    : settings_(settings), rate_Bps_(settings.rate_first_Bps) {
  tokens_bytes_ = std::max(rate_Bps_ * kBurst_s, kBurstMin_bytes);
}

void SendQueue::add(const FactPtr& fact, bool asked) {
  Waiting& waiting = waiting_[{class_of(*fact), fact->t.ns, fact->key}];
  // A fact sent unasked needs no credit, even if it is requested too.
  waiting.asked = waiting.fact == nullptr ? asked : waiting.asked && asked;
  waiting.fact = fact;
}

void SendQueue::fill_bucket(Time now) {
  if (filled_) {
    const double maximum = std::max(rate_Bps_ * kBurst_s, kBurstMin_bytes);
    tokens_bytes_ = std::min(tokens_bytes_ + (now - *filled_).s() * rate_Bps_, maximum);
  }
  filled_ = now;
}

std::vector<FactPtr> SendQueue::take(Time now) {
  fill_bucket(now);
  std::vector<FactPtr> out;
  for (auto it = waiting_.begin(); it != waiting_.end();) {
    if (tokens_bytes_ <= 0.0) {
      was_full_ = true;
      break;
    }
    if (it->second.asked && credit_bytes_ <= 0.0) {
      ++it;
      continue;
    }
    const FactPtr fact = it->second.fact;
    const std::size_t bytes = bytes_about(*fact);
    tokens_bytes_ -= static_cast<double>(bytes);
    if (it->second.asked) credit_bytes_ -= static_cast<double>(bytes);
    if (unconfirmed_.size() < kUnconfirmedMax) unconfirmed_[fact->key] = {now, bytes};
    out.push_back(fact);
    it = waiting_.erase(it);
  }
  return out;
}

void SendQueue::confirm(const Holdings& holdings, Time now) {
  for (auto it = waiting_.begin(); it != waiting_.end();) {
    it = holds(holdings, it->second.fact->key) ? waiting_.erase(it) : std::next(it);
  }
  std::size_t came = 0, lost = 0;
  for (auto it = unconfirmed_.begin(); it != unconfirmed_.end();) {
    const bool has_come = holds(holdings, it->first);
    // A fact sent shortly before the inventory may still be in transit.
    const bool overdue = (now - it->second.t).s() > settings_.inventory_s;
    (has_come ? came : lost) += has_come || overdue ? it->second.bytes : 0;
    it = has_come || overdue ? unconfirmed_.erase(it) : std::next(it);
  }
  adapt(came, lost, now);
}

/// Loss alone is no reason to send less, because the radio loses messages, too. A full link that
/// loses most is limited to a fraction of its goodput.
void SendQueue::adapt(std::size_t came, std::size_t lost, Time now) {
  if (came + lost < kJudgedBytesMin) return;
  const auto fraction = static_cast<double>(came) / static_cast<double>(came + lost);
  if (was_full_ && fraction >= kCameFractionMin) {
    rate_Bps_ *= kRateGrowth;
  } else if (was_full_ && confirmed_ && now > *confirmed_) {
    const double goodput_Bps = static_cast<double>(came) / (now - *confirmed_).s();
    rate_Bps_ = std::min(rate_Bps_, settings_.goodput_fraction * goodput_Bps);
  }
  rate_Bps_ = std::clamp(rate_Bps_, settings_.rate_min_Bps, settings_.rate_max_Bps);
  was_full_ = false;
  confirmed_ = now;
}

bool SendQueue::just_sent(const FactKey& key, Time now, double s) const {
  const auto found = unconfirmed_.find(key);
  return found != unconfirmed_.end() && (now - found->second.t).s() < s;
}

}  // namespace rali::fleet
