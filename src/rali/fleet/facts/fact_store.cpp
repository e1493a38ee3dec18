#include "rali/fleet/facts/fact_store.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "rali/fleet/facts/quantise.hpp"

namespace rali::fleet {

FactStore::FactStore(VehicleId self, std::vector<VehicleId> fleet, StoreLimits limits)
    : self_(self), fleet_(std::move(fleet)), limits_(limits) {
  std::sort(fleet_.begin(), fleet_.end());
}

Result<FactPtr> FactStore::add_own(const Fact& fact) {
  if (fact.key.vehicle != self_) {
    return fail(ErrorCode::kInput, text_of(fact.key), "the fact is another vehicle's");
  }
  Result<Fact> rounded = quantised(fact);
  if (!rounded) return tl::make_unexpected(std::move(rounded.error()));
  auto shared = std::make_shared<const Fact>(std::move(*rounded));
  if (add(shared) != Added::kNew) {
    return fail(ErrorCode::kInput, text_of(fact.key),
                "the fact could not be kept: its number was used before or there are too many",
                "Raise the epoch at each start of the odometry.");
  }
  return shared;
}

bool FactStore::within_limits(const FactKey& key) const {
  if (!std::binary_search(fleet_.begin(), fleet_.end(), key.vehicle)) return false;
  // An inventory cannot express an end beyond the largest number.
  if (key.seq == std::numeric_limits<std::uint32_t>::max()) return false;
  if (size_ >= limits_.facts) return false;
  const auto found = streams_.find({key.vehicle, key.epoch});
  if (found == streams_.end()) {
    return streams_.size() < limits_.streams && (key.seq == 0 || gaps_ < limits_.gaps);
  }
  const SeqSet& held = found->second.held;
  return gaps_ - held.gap_count() + held.gap_count_with(key.seq) <= limits_.gaps;
}

FactStore::Added FactStore::add(FactPtr fact) {
  const FactKey key = fact->key;
  const std::uint64_t hash = content_hash(*fact);
  const auto known = streams_.find({key.vehicle, key.epoch});
  if (known != streams_.end()) {
    const auto found = known->second.facts.find(key.seq);
    if (found != known->second.facts.end()) {
      if (found->second.hash == hash) return Added::kKnown;
      report_conflict(key, fact->t, known->second);
      return Added::kConflict;
    }
  }
  if (!within_limits(key)) {
    ++refused_;
    return Added::kRefused;
  }
  Stream& stream = streams_[{key.vehicle, key.epoch}];
  const std::size_t gaps_before = stream.held.gap_count();
  stream.held.insert(key.seq);
  gaps_ += stream.held.gap_count() - gaps_before;
  stream.facts.emplace(key.seq, Entry{fact, hash});
  ++size_;
  if (logs_) unsaved_.push_back(fact);
  new_.push_back(std::move(fact));
  return Added::kNew;
}

FactStore::Added FactStore::restore(FactPtr fact) {
  const FactKey key = fact->key;
  const Added added = add(std::move(fact));
  if (added == Added::kNew && logs_) {
    unsaved_.pop_back();
    persisted(key);
  }
  return added;
}

void FactStore::persisted(const FactKey& key) {
  const auto found = streams_.find({key.vehicle, key.epoch});
  if (found == streams_.end() || !found->second.held.contains(key.seq)) return;
  found->second.on_disk.insert(key.seq);
}

/// Once per stream: a cloned disk causes as many conflicts as facts.
void FactStore::report_conflict(const FactKey& key, Time t, Stream& stream) {
  if (std::exchange(stream.conflict_reported, true)) return;
  Finding finding;
  finding.id = "fleet.conflict";
  finding.severity = Severity::kError;
  finding.t = t;
  finding.text = fmt::format("two different facts have one name: {}", text_of(key));
  finding.effect =
      "the first one is kept; vehicles that received the second first have another map";
  finding.remedy =
      "Look for two vehicles with one number, a cloned disk, or an epoch that was not raised.";
  findings_.push_back(std::move(finding));
}

std::vector<FactPtr> FactStore::take_new() { return std::exchange(new_, {}); }

FindingList FactStore::take_findings() { return std::exchange(findings_, {}); }

FactPtr FactStore::find(const FactKey& key) const {
  const auto stream = streams_.find({key.vehicle, key.epoch});
  if (stream == streams_.end()) return nullptr;
  const auto found = stream->second.facts.find(key.seq);
  return found == stream->second.facts.end() ? nullptr : found->second.fact;
}

const SeqSet& FactStore::held(const StreamKey& stream) const {
  static const SeqSet kNothing;
  const auto found = streams_.find(stream);
  return found == streams_.end() ? kNothing : found->second.held;
}

Inventory FactStore::inventory(std::uint32_t number, std::uint64_t free_bytes) const {
  if (!logs_) return {number, free_bytes, streams()};
  Inventory inventory{number, free_bytes, {}};
  for (const auto& [key, stream] : streams_) {
    if (stream.on_disk.empty()) continue;
    inventory.streams.push_back(
        {key, static_cast<std::uint32_t>(stream.on_disk.end()), stream.on_disk.gaps()});
  }
  return inventory;
}

std::vector<StreamInventory> FactStore::streams() const {
  std::vector<StreamInventory> out;
  for (const auto& [key, stream] : streams_) {
    out.push_back({key, static_cast<std::uint32_t>(stream.held.end()), stream.held.gaps()});
  }
  return out;
}

std::uint64_t FactStore::hash() const {
  // By key, so that the order of arrival has no effect.
  std::uint64_t h = 0xCBF29CE484222325ULL;
  const auto mix = [&h](std::uint64_t word) {
    h = (h ^ word) * 0x9E3779B97F4A7C15ULL;
    h ^= h >> 32;
  };
  for (const auto& [key, stream] : streams_) {
    mix(std::uint64_t{key.vehicle.value} << 32 | key.epoch);
    for (const auto& [seq, entry] : stream.facts) {
      mix(seq);
      mix(entry.hash);
    }
  }
  return h;
}

}  // namespace rali::fleet
