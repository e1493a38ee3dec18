#include "rali/ranging/exchange_pairer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rali::ranging {

using sensor::RangeSample;

namespace {

/// 0: reported by the lower end of the pair, 1: by the higher one.
int direction_of(const RangeSample& s) {
  return std::pair(s.from, s.from_antenna) <= std::pair(s.to, s.to_antenna) ? 0 : 1;
}

/// Mean of two powers, where 0 means not known.
double mean_power(double a_dbm, double b_dbm) {
  if (a_dbm == 0.0) return b_dbm;
  if (b_dbm == 0.0) return a_dbm;
  return 0.5 * (a_dbm + b_dbm);
}

/// Both directions as one range, with the ends as in `a`.
RangeSample merged(const RangeSample& a, const RangeSample& b) {
  RangeSample out = a;
  out.t = a.t + Duration::from_ns((b.t - a.t).ns / 2);
  out.range_m = 0.5 * (a.range_m + b.range_m);
  out.sigma_m = std::max(a.sigma_m, b.sigma_m);
  out.rssi_dbm = mean_power(a.rssi_dbm, b.rssi_dbm);
  out.first_path_dbm = mean_power(a.first_path_dbm, b.first_path_dbm);
  return out;
}

}  // namespace

ExchangePairer::ExchangePairer(const ExchangeSettings& settings) : settings_(settings) {}

bool ExchangePairer::within_half_slot(Time a, Time b) const {
  return std::abs(seconds_between(a, b)) <= 0.5 * settings_.slot_s;
}

ExchangePairer::Past* ExchangePairer::find(Link& link, Time from, Time to, bool same_direction,
                                           const RangeSample& sample) {
  const auto end = link.past.upper_bound(to.ns);
  for (auto it = link.past.lower_bound(from.ns); it != end; ++it) {
    Past& past = it->second;
    const bool same = direction_of(past.sample) == direction_of(sample);
    if (same == same_direction && (same || !past.paired)) return &past;
  }
  return nullptr;
}

void ExchangePairer::remember(Link& link, const RangeSample& sample, bool paired) const {
  link.past.emplace(sample.t.ns, Past{sample, paired});
  if (link.past.size() <= static_cast<std::size_t>(settings_.history)) return;
  // The one farthest away in time: after a clock went back the newest are useless.
  const auto last = std::prev(link.past.end());
  const bool first_is_farther =
      sample.t - Time{link.past.begin()->first} >= Time{last->first} - sample.t;
  link.past.erase(first_is_farther ? link.past.begin() : last);
}

void ExchangePairer::join(Link& link, Past& partner, const RangeSample& sample,
                          std::vector<PairedRange>& out) {
  const RangeSample first = partner.sample;
  partner.paired = true;
  const bool agree = std::abs(first.range_m - sample.range_m) <= settings_.agree_m;
  const bool waits = link.waiting && link.waiting->t == first.t &&
                     direction_of(*link.waiting) == direction_of(first);
  if (waits) {
    out.push_back({agree ? merged(first, sample) : first, false});
    link.waiting.reset();
  }
  out.push_back({sample, agree});
  remember(link, sample, true);
}

void ExchangePairer::add(const RangeSample& sample, std::vector<PairedRange>& out) {
  release(sample.t, out);
  if (!std::isfinite(sample.range_m)) {
    out.push_back({sample, false});  // not to be averaged; a later stage gives the reason
    return;
  }
  const bool low = direction_of(sample) == 0;
  const Key key =
      low ? Key{sample.from.value, sample.to.value, sample.from_antenna, sample.to_antenna}
          : Key{sample.to.value, sample.from.value, sample.to_antenna, sample.from_antenna};
  Link& link = links_[key];
  if (find(link, sample.t, sample.t, true, sample) != nullptr) {
    out.push_back({sample, true});
    return;
  }
  link.received[low ? 0 : 1] = true;
  const Duration half = Duration::from_s(0.5 * settings_.slot_s);
  if (Past* partner = find(link, sample.t - half, sample.t + half, false, sample)) {
    return join(link, *partner, sample, out);
  }
  remember(link, sample, false);
  const bool late = link.waiting && sample.t < link.waiting->t;
  if (late || !link.received[0] || !link.received[1]) {
    out.push_back({sample, false});
    return;
  }
  // Two of one direction within half a slot are two exchanges: the first waits no longer.
  if (link.waiting) out.push_back({*link.waiting, false});
  link.waiting = sample;
  waiting_.push_back(key);
}

void ExchangePairer::release(Time now, std::vector<PairedRange>& out) {
  std::size_t kept = 0;
  for (const Key& key : waiting_) {
    std::optional<RangeSample>& waiting = links_[key].waiting;
    if (!waiting) continue;  // is paired
    if (waiting->t >= now || within_half_slot(waiting->t, now)) {
      waiting_[kept++] = key;
      continue;
    }
    out.push_back({*waiting, false});
    waiting.reset();
  }
  waiting_.resize(kept);
}

void ExchangePairer::flush(std::vector<PairedRange>& out) {
  for (const Key& key : waiting_) {
    Link& link = links_[key];
    if (link.waiting) out.push_back({*link.waiting, false});
    link.waiting.reset();
  }
  waiting_.clear();
}

}  // namespace rali::ranging
