#include "rali/drive/state/state_dir.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "rali/base/finding_of.hpp"
#include "rali/drive/state/fact_record.hpp"
#include "rali/drive/state/role_record.hpp"
#include "rali/fleet/facts/keyframe_number.hpp"
#include "rali/fleet/facts/quantise.hpp"
#include "rali/fleet/messages/kind.hpp"
#include "rali/wire/fleet/codec.hpp"

namespace rali::drive {

namespace {

/// Starts whose epoch may be on no disk after the role was lost. Each epoch is on the disk before
/// its first fact is sent, but that fact need not be.
constexpr std::uint32_t kEpochsSkipped = 16;

/// The newest epoch of a vehicle's own facts in a log.
std::optional<std::uint32_t> last_epoch(const std::vector<fleet::FactPtr>& facts, VehicleId self) {
  std::optional<std::uint32_t> last;
  for (const fleet::FactPtr& fact : facts) {
    if (fact->key.vehicle == self) last = std::max(last.value_or(0), fact->key.epoch);
  }
  return last;
}

}  // namespace

Result<StateDir> StateDir::open(const std::string& folder, VehicleId self,
                                const std::vector<VehicleId>& fleet,
                                const StateSettings& settings) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return fail(ErrorCode::kMachine, folder, "could not be made: " + error.message(),
                "Name a folder that can be written.");
  }
  auto log = factlog::DiskLog::open(folder, settings.log);
  if (!log) return tl::make_unexpected(log.error());
  auto slots = factlog::DiskSlots::open(folder, "role.slots");
  if (!slots) return tl::make_unexpected(slots.error());
  auto seen = factlog::DiskSlots::open(folder, "seen.slots");
  if (!seen) return tl::make_unexpected(seen.error());
  auto state = restore(std::move(*log), std::make_shared<factlog::DiskSlots>(std::move(*slots)),
                       self, fleet, settings);
  if (!state) return state;
  state->seen_slots_ = std::make_shared<factlog::DiskSlots>(std::move(*seen));
  state->seen_ = state->seen_kept_ = state->seen_slots_->content();
  return state;
}

Result<StateDir> StateDir::restore(std::shared_ptr<factlog::FactLog> log,
                                   std::shared_ptr<factlog::RoleSlots> slots, VehicleId self,
                                   const std::vector<VehicleId>& fleet,
                                   const StateSettings& settings) {
  StateDir state(std::move(log), std::move(slots), self, settings);
  state.read_facts(fleet);
  if (auto status = state.read_role(fleet); !status) return tl::make_unexpected(status.error());
  state.start_.logs = true;
  state.start_.epoch = state.epoch_;
  if (state.epoch_ >= fleet::kEpochsMax) {
    return fail(ErrorCode::kInput, "state of the vehicle",
                fmt::format("{} starts have used all epochs", fleet::kEpochsMax),
                "Give the vehicle another number and a new folder.");
  }
  // Before the first fact of the new epoch can be sent.
  if (auto status = state.save_role(state.start_.durable); !status) {
    return tl::make_unexpected(status.error());
  }
  return state;
}

void StateDir::read_facts(const std::vector<VehicleId>& fleet) {
  std::size_t strangers = 0;
  log_->for_each(
      [&](const factlog::RecordKey& key, std::uint8_t, std::span<const std::byte> bytes) {
        const auto fact = decode_record(key, bytes);
        if (fact && std::find(fleet.begin(), fleet.end(), key.vehicle) == fleet.end()) {
          ++strangers;
        } else if (fact) {
          start_.facts.push_back(*fact);
        } else {
          findings_.push_back(finding_of(
              "log.unreadable", Severity::kWarning,
              fmt::format("a fact of the log cannot be read: {}", fact.error().message()),
              "it is left out and requested from other vehicles", ""));
        }
        return true;
      });
  if (strangers == 0) return;
  findings_.push_back(finding_of(
      "log.strangers", Severity::kWarning,
      fmt::format("{} facts of the log are of vehicles that are not in the fleet", strangers),
      "they are left out", "Check the fleet's list of vehicles."));
}

Status StateDir::read_role(const std::vector<VehicleId>& fleet) {
  const std::optional<std::uint32_t> used = last_epoch(start_.facts, self_);
  fleet::DurableRole newcomer;
  newcomer.fleet = fleet;
  std::sort(newcomer.fleet.begin(), newcomer.fleet.end());
  start_.durable = newcomer;
  using State = factlog::RoleSlots::State;
  if (slots_->state() == State::kNew && log_->size() == 0) return {};
  Result<RoleRecord> read = fail(ErrorCode::kInput, "role slots", "neither can be read");
  if (slots_->state() == State::kRead) read = decode_role(slots_->content());
  if (!read && read.error().code == ErrorCode::kNoAnswer) {
    return tl::make_unexpected(read.error());
  }
  if (!read) {
    start_.durable.confirmed = false;
    epoch_ = used.value_or(0) + kEpochsSkipped;
    findings_.push_back(finding_of(
        "state.role_unreadable", Severity::kError,
        "the vehicle's role cannot be read from its disk, and votes it gave may be forgotten",
        "it votes for nobody and is no candidate for anchor",
        "Confirm the role when no other vehicle waits for this one's vote."));
    return {};
  }
  if (read->self != self_) {
    return fail(ErrorCode::kUsage, "state of the vehicle",
                fmt::format("is that of vehicle number {}, not {}", read->self.value, self_.value),
                "Each vehicle has a folder of its own.");
  }
  start_.durable = read->durable;
  if (start_.durable.fleet != newcomer.fleet) {
    findings_.push_back(finding_of(
        "state.fleet", Severity::kWarning,
        fmt::format("the fleet had {} vehicles when the role was last saved, now {} are named",
                    start_.durable.fleet.size(), newcomer.fleet.size()),
        "votes count against the former list", "Change the fleet by the operator's command."));
  }
  epoch_ = std::max(read->epoch, used.value_or(0)) + 1;
  if (slots_->one_is_damaged()) {
    findings_.push_back(finding_of("state.role_slot", Severity::kWarning,
                                   "one of the two slots of the vehicle's role cannot be read",
                                   "the other one is used: the write was cut short, or the disk "
                                   "is damaged",
                                   ""));
  }
  return {};
}

Status StateDir::save_role(const fleet::DurableRole& durable) {
  return slots_->save(encode_role({self_, epoch_, durable}));
}

bool StateDir::take(const fleet::NodeOutput& output) {
  if (const auto* fact = std::get_if<fleet::SaveFact>(&output)) {
    take_fact(fact->fact);
    return true;
  }
  if (const auto* role = std::get_if<fleet::SaveRole>(&output)) {
    role_ = *role;  // a later role contains all earlier changes
    return true;
  }
  return false;
}

void StateDir::take_fact(const fleet::FactPtr& fact) {
  std::string why;
  if (!write(fact, why)) note_failure(fact, std::move(why));
}

bool StateDir::write(const fleet::FactPtr& fact, std::string& why) {
  // A full disk keeps longest the facts that no other fact replaces (middleware 4.4).
  const fleet::Kind kind = fleet::kind_of(*fact);
  const std::uint64_t reserve = kind == fleet::Kind::kFinePoints     ? 2 * settings_.reserve_bytes
                                : kind == fleet::Kind::kCoarsePoints ? settings_.reserve_bytes
                                                                     : 0;
  if (reserve > 0 && log_->free_bytes() < reserve) {
    why = "it is nearly full";
    return false;
  }
  const auto bytes =
      wire::encode_envelope({fact->key.vehicle, std::nullopt, fleet::FactMessage{fact}});
  if (!bytes) {
    // The radio rejects it, too.
    findings_.push_back(finding_of("log.refused", Severity::kError, bytes.error().message(),
                                   "it is not in the log", ""));
    return true;
  }
  const auto appended =
      log_->append(record_key(fact->key), static_cast<std::uint8_t>(kind), *bytes);
  if (!appended || *appended == factlog::Appended::kFull) {
    why = appended ? "it is full" : appended.error().message();
    return false;
  }
  // The log itself reports a conflict; its record is not this fact.
  if (*appended != factlog::Appended::kConflict) unsynced_.push_back(fact);
  return true;
}

void StateDir::note_failure(const fleet::FactPtr& fact, std::string why) {
  failing_.push_back(fact);
  failed_.facts.push_back(fact->key);
  failed_.why = std::move(why);
}

std::vector<fleet::NodeEvent> StateDir::sync(Time now, bool all) {
  fleet::Persisted kept;
  const Status role_saved = role_ ? save_role(role_->durable) : Status{};
  const bool role_is_new = role_ && role_saved;
  if (role_is_new) {
    role_kept_ = role_->number;
    role_.reset();
  }
  kept.role = role_kept_;
  sync_seen();
  if (!synced_) synced_ = now;
  const std::size_t failing_before = failing_.size();
  if (!failing_.empty() && (!retried_ || seconds_between(*retried_, now) >= settings_.retry_s)) {
    retried_ = now;
    retry();
  }
  const bool due = all || unsynced_.size() >= settings_.sync_facts ||
                   seconds_between(*synced_, now) >= settings_.sync_s;
  if (due) {
    synced_ = now;
    sync_facts(kept.facts);
  }
  kept.free_bytes = log_->free_bytes();
  kept.failing_facts = failing_.size();
  std::vector<fleet::NodeEvent> events;
  // A role that could not be saved is tried again; messages that depend on it stay unsent.
  if (!role_saved) failed_.why = role_saved.error().message();
  if (!failed_.facts.empty() || !role_saved) events.emplace_back(std::exchange(failed_, {}));
  const bool recovered = failing_before > 0 && failing_.empty() && role_saved;
  if (role_is_new || !kept.facts.empty() || recovered) events.emplace_back(std::move(kept));
  return events;
}

/// A disk that refuses them refuses facts, too, which is reported; the next ones are tried again.
void StateDir::sync_seen() {
  if (seen_slots_ == nullptr || seen_ == seen_kept_) return;
  if (seen_slots_->save(seen_)) seen_kept_ = seen_;
}

void StateDir::sync_facts(std::vector<fleet::FactKey>& kept) {
  if (unsynced_.empty()) return;
  const Status synced = log_->sync();
  for (const fleet::FactPtr& fact : std::exchange(unsynced_, {})) {
    if (synced) {
      kept.push_back(fact->key);
    } else {
      note_failure(fact, synced.error().message());
    }
  }
}

void StateDir::retry() {
  std::string why;
  for (std::size_t left = failing_.size(); left > 0; --left) {
    const fleet::FactPtr fact = failing_.front();
    failing_.pop_front();
    if (!write(fact, why)) failing_.push_back(fact);
  }
}

FindingList StateDir::take_findings() {
  FindingList out = std::exchange(findings_, {});
  for (Finding& finding : log_->take_findings()) out.push_back(std::move(finding));
  return out;
}

}  // namespace rali::drive
