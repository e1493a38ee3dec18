#include "rali/jobs/load_states.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "rali/base/finding_of.hpp"
#include "rali/io/input_kind.hpp"

namespace rali::jobs {
namespace {

using config::FleetConfig;
using drive::FleetFacts;

/// Antennas of fleet.yaml and of the facts may differ by rounding.
constexpr double kSame_m = 0.001;

/// State folders, and one fleet.yaml at most.
struct Sorted {
  std::string yaml;
  std::vector<std::string> folders;
};

Result<Sorted> sorted(const std::vector<std::string>& inputs) {
  Sorted out;
  for (const std::string& input : inputs) {
    if (!is_yaml(input)) {
      // An input that is neither a recording nor a state folder is reported when folders are read.
      const bool other = !drive::is_state_folder(input) && io::input_kind(input);
      if (other) {
        return fail(ErrorCode::kUsage, input,
                    "is no state folder of a vehicle, as others of the inputs are",
                    "Give either recordings or state folders.");
      }
      out.folders.push_back(input);
      continue;
    }
    if (!out.yaml.empty()) {
      return fail(ErrorCode::kUsage, input, "is a second fleet.yaml beside " + out.yaml,
                  "Give the one with which the vehicles ran.");
    }
    out.yaml = input;
  }
  return out;
}

/// Matches the members with the vehicles of the file, by name, one for each.
Status take_names(const std::string& file, const FleetConfig& fleet, FleetFacts& facts) {
  const std::size_t vehicles = fleet.vehicles.size();
  for (std::size_t k = 0; k < facts.members.size(); ++k) {
    FleetFacts::Member& member = facts.members[k];
    const std::string here = k < vehicles ? fleet.vehicles[k].name : "";
    if (k >= vehicles || (member.named && member.name != here)) {
      return fail(ErrorCode::kUsage, facts.folders.front(),
                  fmt::format("vehicle {} of its fleet is '{}', that of {} {}", k + 1, member.name,
                              file, k < vehicles ? "'" + here + "'" : "does not exist"),
                  "Give the fleet.yaml with which the vehicles ran.");
    }
    member.name = here;
  }
  facts.members.resize(vehicles);
  for (std::size_t k = 0; k < vehicles; ++k) facts.members[k].name = fleet.vehicles[k].name;
  return {};
}

void compare_antennas(const std::string& file, const FleetConfig& fleet, FleetFacts& facts) {
  for (std::size_t k = 0; k < facts.members.size(); ++k) {
    const FleetFacts::Member& member = facts.members[k];
    const auto& here = fleet.vehicles[k].antennas;
    const bool same = std::equal(
        here.begin(), here.end(), member.antennas_body_m.begin(), member.antennas_body_m.end(),
        [](const auto& a, const auto& p_m) { return (a.p_body_m - p_m).norm() < kSame_m; });
    if (same || !member.named) continue;
    Finding f = finding_of("state.antennas", Severity::kWarning,
                           fmt::format("its antennas in {} are not those with which it ran", file),
                           "those of the live mission are used");
    f.vehicle = member.name;
    facts.findings.push_back(std::move(f));
  }
}

/// Recordings and the files beside them are not used in a map of facts.
void forget_recordings(const std::string& file, FleetConfig& fleet) {
  bool any = false;
  for (config::VehicleConfig& vehicle : fleet.vehicles) {
    any |= !vehicle.recordings.empty();
    vehicle.recordings.clear();
    vehicle.start_s = vehicle.duration_s = 0.0;
  }
  any |= std::any_of(fleet.ranges.sources.begin(), fleet.ranges.sources.end(),
                     [](const config::RangeSource& s) { return s.topic.empty(); });
  fleet.ranges.sources.clear();
  if (!any) return;
  fleet.notices.push_back(file +
                          ": its recordings and files of ranges are left out, since the map "
                          "is made from state folders");
}

Result<FleetConfig> fleet_of(const FleetFacts& facts, const config::Overrides& overrides) {
  std::vector<std::string> names;
  for (const FleetFacts::Member& member : facts.members) names.push_back(member.name);
  Result<FleetConfig> fleet = config::fleet_of_names(names, overrides);
  for (std::size_t k = 0; fleet && k < names.size(); ++k) {
    auto& antennas = fleet->vehicles[k].antennas;
    if (facts.members[k].antennas_body_m.empty()) continue;
    antennas.clear();
    for (const geometry::Vec3& p_body_m : facts.members[k].antennas_body_m) {
      const std::string more = antennas.empty() ? "" : fmt::format("_{}", antennas.size() + 1);
      antennas.push_back({"uwb" + more, p_body_m});
    }
    fleet->origins["vehicles." + names[k] + ".antennas"] = "found: the vehicle's facts";
  }
  return fleet;
}

}  // namespace

Result<MapInputs> load_states(const std::vector<std::string>& inputs,
                              const config::Overrides& overrides) {
  const Result<Sorted> found = sorted(inputs);
  if (!found) return tl::make_unexpected(found.error());
  Result<FleetFacts> read = drive::read_fleet_facts(found->folders);
  if (!read) return tl::make_unexpected(read.error());
  config::Overrides live = overrides;
  live.live = true;
  Result<FleetConfig> fleet =
      found->yaml.empty() ? fleet_of(*read, live) : config::load_fleet(found->yaml, live);
  if (!fleet) return tl::make_unexpected(fleet.error());
  if (!found->yaml.empty()) {
    if (Status s = take_names(found->yaml, *fleet, *read); !s)
      return tl::make_unexpected(s.error());
    compare_antennas(found->yaml, *fleet, *read);
    forget_recordings(found->yaml, *fleet);
  }
  return MapInputs{std::move(*fleet), std::make_shared<const FleetFacts>(std::move(*read))};
}

}  // namespace rali::jobs
