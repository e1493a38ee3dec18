#include "rali/drive/state/fleet_facts.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/base/finding_of.hpp"
#include "rali/config/vehicle_name.hpp"
#include "rali/drive/state/fact_record.hpp"
#include "rali/factlog/disk_log.hpp"
#include "rali/fleet/facts/quantise.hpp"

namespace rali::drive {
namespace {

namespace fs = std::filesystem;

/// The maximum of a fleet.yaml. A larger number in a log is damage, or of another program.
constexpr std::size_t kVehiclesMax = 64;

/// Each folder once, by name.
std::vector<std::string> distinct(std::vector<std::string> folders) {
  std::sort(folders.begin(), folders.end());
  std::set<fs::path> seen;
  std::erase_if(folders, [&](const std::string& folder) {
    std::error_code error;
    const fs::path path = fs::weakly_canonical(folder, error);
    return !seen.insert(error ? fs::path(folder) : path).second;
  });
  return folders;
}

/// Merges the facts of several folders.
class Union {
 public:
  Status add(const std::string& folder);
  Result<FleetFacts> take(std::vector<std::string> folders);

 private:
  struct Known {
    fleet::FactPtr fact;
    std::size_t folder = 0;  ///< from which it was read first
  };

  Status add_fact(const fleet::FactPtr& fact);
  FleetFacts::Member member(std::uint16_t number, const fleet::FactPtr* first,
                            const fleet::FactPtr* last) const;
  Status check_names(const FleetFacts& facts) const;

  std::map<fleet::FactKey, Known> facts_;
  std::vector<std::string> folders_;
  FindingList findings_;
};

Status Union::add(const std::string& folder) {
  std::error_code error;
  if (!fs::exists(folder, error)) {
    return fail(ErrorCode::kInput, folder, "there is no such folder");
  }
  if (!is_state_folder(folder)) {
    return fail(ErrorCode::kInput, folder, "is no state folder of a vehicle (facts-*.log)",
                "Give the folders that rali run --state named.");
  }
  const auto log = factlog::DiskLog::open_to_read(folder);
  if (!log) return tl::make_unexpected(log.error());
  folders_.push_back(folder);
  Status status;
  std::size_t unreadable = 0, strangers = 0;
  std::string why;
  (*log)->for_each(
      [&](const factlog::RecordKey& key, std::uint8_t, std::span<const std::byte> bytes) {
        const auto fact = decode_record(key, bytes);
        if (!fact && unreadable++ == 0) why = fact.error().message();
        if (fact && key.vehicle.value >= kVehiclesMax) ++strangers;
        if (fact && key.vehicle.value < kVehiclesMax) status = add_fact(*fact);
        return status.has_value();
      });
  for (Finding& finding : (*log)->take_findings()) findings_.push_back(std::move(finding));
  if (unreadable > 0) {
    findings_.push_back(finding_of(
        "log.unreadable", Severity::kWarning,
        fmt::format("{}: {} cannot be read: {}", folder, counted(unreadable, "fact"), why),
        "they are left out"));
  }
  if (strangers > 0) {
    findings_.push_back(finding_of("log.strangers", Severity::kWarning,
                                   fmt::format("{}: {} of vehicles with numbers above {}", folder,
                                               counted(strangers, "fact"), kVehiclesMax),
                                   "they are left out"));
  }
  return status;
}

Status Union::add_fact(const fleet::FactPtr& fact) {
  const auto [known, added] = facts_.try_emplace(fact->key, Known{fact, folders_.size() - 1});
  if (added || fleet::content_hash(*known->second.fact) == fleet::content_hash(*fact)) return {};
  return fail(ErrorCode::kInput, folders_.back(),
              fmt::format("contradicts {}: vehicle {}, start {}, fact {} is another one there",
                          folders_[known->second.folder], fact->key.vehicle.value + 1,
                          fact->key.epoch + 1, fact->key.seq),
              "Give folders of one mission of one fleet.");
}

/// @param first, last range of its facts, by key
FleetFacts::Member Union::member(std::uint16_t number, const fleet::FactPtr* first,
                                 const fleet::FactPtr* last) const {
  FleetFacts::Member member;
  member.name = fmt::format("vehicle_{}", number + 1);
  member.facts.assign(first, last);
  for (std::size_t k = 0; k < member.facts.size(); ++k) {
    const fleet::Fact& fact = *member.facts[k];
    const bool follows = k > 0 && member.facts[k - 1]->key.epoch == fact.key.epoch;
    member.missing += fact.key.seq - (follows ? member.facts[k - 1]->key.seq + 1 : 0);
    const auto* start = std::get_if<fleet::EpochStart>(&fact.body);
    // A name becomes part of file names: one that is invalid in fleet.yaml is ignored.
    if (start == nullptr || !config::is_vehicle_name(start->name)) continue;
    member.name = start->name;
    member.named = true;
    member.antennas_body_m = start->antennas_body_m;
  }
  return member;
}

Status Union::check_names(const FleetFacts& facts) const {
  std::map<std::string, std::size_t> numbers;
  for (std::size_t k = 0; k < facts.members.size(); ++k) {
    const auto [other, added] = numbers.emplace(facts.members[k].name, k);
    if (added) continue;
    return fail(ErrorCode::kInput, facts.folders.front(),
                fmt::format("vehicles {} and {} are both named '{}'", other->second + 1, k + 1,
                            other->first),
                "Give folders of one mission of one fleet.");
  }
  return {};
}

Result<FleetFacts> Union::take(std::vector<std::string> folders) {
  FleetFacts out;
  out.folders = std::move(folders);
  out.findings = std::move(findings_);
  if (facts_.empty()) {
    return fail(ErrorCode::kInput, out.folders.front(),
                "holds no fact: its vehicle has not mapped anything yet",
                "Start it with rali run, or give the folder of another vehicle.");
  }
  std::vector<fleet::FactPtr> all;
  for (auto& [key, known] : facts_) all.push_back(std::move(known.fact));
  const fleet::FactPtr* at = all.data();
  const fleet::FactPtr* const end = at + all.size();
  const std::uint16_t highest = all.back()->key.vehicle.value;
  for (std::uint16_t number = 0; number <= highest; ++number) {
    const fleet::FactPtr* const first = at;
    while (at != end && (*at)->key.vehicle.value == number) ++at;
    out.members.push_back(member(number, first, at));
  }
  if (Status named = check_names(out); !named) return tl::make_unexpected(named.error());
  return out;
}

}  // namespace

bool is_state_folder(const std::string& path) {
  std::error_code error;
  fs::directory_iterator at(path, error);
  for (; !error && at != fs::directory_iterator(); at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (name == "role.slots" || (name.starts_with("facts-") && name.ends_with(".log"))) return true;
  }
  return false;
}

Result<FleetFacts> read_fleet_facts(std::vector<std::string> folders) {
  folders = distinct(std::move(folders));
  Union facts;
  for (const std::string& folder : folders) {
    if (Status added = facts.add(folder); !added) return tl::make_unexpected(added.error());
  }
  return facts.take(std::move(folders));
}

}  // namespace rali::drive
