#include "rali/fleet/facts/want_list.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "rali/fleet/facts/quantise.hpp"

namespace rali::fleet {

namespace {

constexpr std::size_t kMissingPerStream = 512;
/// Of all streams together: a peer may list a thousand streams that no vehicle has.
constexpr std::size_t kMissingMax = 16384;
constexpr int kVainMax = 2;
constexpr double kSizeGain = 0.1;
/// RFC 6298, section 2.
constexpr double kMeanGain = 0.125, kDeviationGain = 0.25, kDeviations = 4.0;

const SeqSet* holdings_of(const Holder& holder, const StreamKey& stream) {
  const auto found = holder.holdings->find(stream);
  return found == holder.holdings->end() ? nullptr : &found->second;
}

/// Whether a later epoch of the author is known, or the author is this vehicle itself.
bool has_restarted(VehicleId self, const StreamKey& stream, const std::vector<Holder>& holders) {
  if (stream.vehicle == self) return true;
  return std::any_of(holders.begin(), holders.end(), [&](const Holder& holder) {
    if (holder.vehicle != stream.vehicle) return false;
    const auto later = holder.holdings->upper_bound(stream);
    return later != holder.holdings->end() && later->first.vehicle == stream.vehicle;
  });
}

/// Extends the last interval if the number follows it, else appends a new one.
void append(std::vector<Want>& wants, const FactKey& key) {
  const StreamKey stream{key.vehicle, key.epoch};
  if (!wants.empty() && wants.back().stream == stream && wants.back().numbers.last + 1 == key.seq) {
    wants.back().numbers.last = key.seq;
    return;
  }
  wants.push_back({stream, {key.seq, key.seq}, 0});
}

}  // namespace

void Patience::sample(double s) {
  if (!mean_s_) {
    mean_s_ = s;
    deviation_s_ = 0.5 * s;
    return;
  }
  deviation_s_ += kDeviationGain * (std::abs(s - *mean_s_) - deviation_s_);
  *mean_s_ += kMeanGain * (s - *mean_s_);
}

double Patience::s() const {
  const double s = mean_s_ ? *mean_s_ + kDeviations * deviation_s_ : settings_.patience_first_s;
  return std::clamp(s, settings_.patience_min_s,
                    std::max(settings_.patience_min_s, settings_.patience_max_s));
}

double WantList::patience_s(VehicleId holder) const {
  const auto found = patience_.find(holder);
  return found == patience_.end() ? Patience(settings_).s() : found->second.s();
}

void WantList::refresh(const FactStore& store, const std::vector<Holder>& holders,
                       const Holdings& withheld, Time now) {
  std::set<StreamKey> streams;
  for (const Holder& holder : holders) {
    for (const auto& [stream, numbers] : *holder.holdings) streams.insert(stream);
  }
  for (const StreamInventory& own : store.streams()) streams.insert(own.stream);
  // The same for each stream, so that no stream blocks the requests of another.
  const std::size_t fraction = kMissingMax / std::max<std::size_t>(streams.size(), 1);
  const std::size_t per_stream = std::clamp<std::size_t>(fraction, 1, kMissingPerStream);
  std::map<FactKey, Missing> still;
  for (const StreamKey& stream : streams) {
    const SeqSet& held = store.held(stream);
    const auto kept_back = withheld.find(stream);
    // Facts not written to the author's disk before it stopped are held only by vehicles that list
    // them.
    const bool author_lacks = has_restarted(store.self(), stream, holders);
    std::size_t count = 0;
    std::uint64_t seq = 0;
    while (count < per_stream) {
      if (seq > std::numeric_limits<std::uint32_t>::max()) break;
      // The smallest number that is missing here and held elsewhere: by a holder, or by the author,
      // who has all below the last one held here.
      std::optional<std::uint32_t> next;
      for (const Holder& holder : holders) {
        const SeqSet* theirs = holdings_of(holder, stream);
        if (theirs == nullptr) continue;
        const auto lacking = held.first_lacking(*theirs, static_cast<std::uint32_t>(seq));
        if (lacking) next = std::min(*lacking, next.value_or(*lacking));
      }
      const auto gap = held.first_gap(static_cast<std::uint32_t>(seq));
      if (gap && !author_lacks) {
        next = std::min(*gap, next.value_or(*gap));
      }
      if (!next) break;
      if (kept_back != withheld.end() && kept_back->second.contains(*next)) {
        // The whole interval at once: it may contain billions of numbers.
        const auto after = kept_back->second.first_gap(*next);
        seq = after ? *after : kept_back->second.end();
        continue;
      }
      seq = std::uint64_t{*next} + 1;
      const FactKey key{stream.vehicle, stream.epoch, *next};
      const auto known = missing_.find(key);
      still.emplace(key, known == missing_.end() ? Missing{now, {}, {}, 0} : known->second);
      ++count;
    }
  }
  missing_ = std::move(still);
}

bool WantList::due(const Missing& missing, Time now) const {
  if (missing.asked) return (now - *missing.asked).s() >= patience_s(missing.asked_of);
  return true;
}

const Holder* WantList::choose(const FactKey& key, const Missing& missing, const FactStore& store,
                               const std::vector<Holder>& holders) const {
  const StreamKey stream{key.vehicle, key.epoch};
  const bool vain = missing.times > 0 && missing.times % kVainMax == 0;
  const Holder* best = nullptr;
  const Holder* vainly_asked = nullptr;
  for (const Holder& holder : holders) {
    const SeqSet* theirs = holdings_of(holder, stream);
    const bool author = holder.vehicle == key.vehicle;
    const bool has = (theirs != nullptr && theirs->contains(key.seq)) ||
                     (author && key.seq < store.held(stream).end());
    if (!has) continue;
    if (vain && holder.vehicle == missing.asked_of) {
      vainly_asked = &holder;
      continue;
    }
    if (best != nullptr && best->vehicle == key.vehicle) continue;
    if (best == nullptr || author) best = &holder;
  }
  return best != nullptr ? best : vainly_asked;
}

std::map<VehicleId, double> WantList::outstanding_bytes(Time now) const {
  std::map<VehicleId, double> bytes;
  for (const auto& [key, missing] : missing_) {
    if (missing.asked && !due(missing, now)) bytes[missing.asked_of] += fact_bytes_;
  }
  return bytes;
}

std::map<VehicleId, std::vector<Want>> WantList::ask(const FactStore& store,
                                                     const std::vector<Holder>& holders, Time now) {
  std::map<VehicleId, std::vector<Want>> requests;
  std::map<VehicleId, double> outstanding = outstanding_bytes(now);
  for (auto& [key, missing] : missing_) {
    if (!due(missing, now)) continue;
    const Holder* holder = choose(key, missing, store, holders);
    if (holder == nullptr) continue;
    // A new fact may be in transit already: half a round trip is allowed for it.
    const double on_its_way_s = 0.5 * patience_s(holder->vehicle);
    if (!missing.asked && (now - missing.known).s() < on_its_way_s) continue;
    const auto last = last_request_.find(holder->vehicle);
    if (last != last_request_.end() && (now - last->second).s() < settings_.request_s) continue;
    double& bytes = outstanding[holder->vehicle];
    if (bytes > 0.0 && bytes + fact_bytes_ > settings_.window_bytes) continue;
    bytes += fact_bytes_;
    missing.asked = now;
    missing.asked_of = holder->vehicle;
    ++missing.times;
    append(requests[holder->vehicle], key);
  }
  for (const auto& [vehicle, wants] : requests) last_request_[vehicle] = now;
  return requests;
}

std::size_t WantList::size_of(VehicleId author) const {
  return static_cast<std::size_t>(
      std::count_if(missing_.begin(), missing_.end(),
                    [&](const auto& entry) { return entry.first.vehicle == author; }));
}

void WantList::came(const Fact& fact, VehicleId from, Time now) {
  fact_bytes_ += kSizeGain * (static_cast<double>(bytes_about(fact)) - fact_bytes_);
  const auto found = missing_.find(fact.key);
  if (found == missing_.end()) return;
  // Only the first request of a fact gives a response time: after a second one it is unknown which
  // was answered (Karn).
  const Missing& missing = found->second;
  if (missing.asked && missing.times == 1 && missing.asked_of == from) {
    patience_.emplace(from, Patience(settings_)).first->second.sample((now - *missing.asked).s());
  }
  missing_.erase(found);
}

}  // namespace rali::fleet
