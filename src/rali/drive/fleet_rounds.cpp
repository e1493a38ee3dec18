#include "rali/drive/fleet_rounds.hpp"

#include <algorithm>

#include "rali/drive/output/rounds_files.hpp"

namespace rali::drive {

namespace {

/// Ranges are reported in blocks of one second, after the last of them.
constexpr double kLate_s = 2.0;

}  // namespace

std::vector<Time> round_ends(std::span<const ReportedByVehicle> vehicles, const RoundsJob& job) {
  std::vector<fleet::RoundRow> rounds;
  if (job.from == RoundsFrom::kTable) {
    // A contradictory table is reported where the rounds are written.
    rounds = fleet::rounds_of_table(job.table).value_or(std::vector<fleet::RoundRow>{});
  } else if (job.from == RoundsFrom::kStands) {
    std::vector<fleet::Stand> stands;
    for (const ReportedByVehicle& v : vehicles) {
      if (v.facts.empty()) continue;
      const auto own = stands_of(v.vehicle, v.facts, v.data_end, v.rest_s, job.rounds.stand_min_s);
      stands.insert(stands.end(), own.begin(), own.end());
    }
    rounds = fleet::rounds_of_stands(stands, job.rounds.stand_min_s);
  }
  std::vector<Time> ends;
  for (std::size_t k = 0; k + 1 < rounds.size(); ++k) {
    if (rounds[k].end) ends.push_back(*rounds[k].end);
  }
  std::sort(ends.begin(), ends.end());
  return ends;
}

fleet::FleetEstimate estimate_by_rounds(std::span<const ReportedByVehicle> vehicles,
                                        std::span<const Time> ends, fleet::RoundCentre& centre,
                                        Executor& executor,
                                        const std::function<void(Time)>& ended) {
  std::vector<std::shared_ptr<const fleet::Fact>> facts;
  for (const ReportedByVehicle& v : vehicles) {
    facts.insert(facts.end(), v.facts.begin(), v.facts.end());
  }
  std::stable_sort(facts.begin(), facts.end(),
                   [](const auto& a, const auto& b) { return a->t < b->t; });
  auto next = facts.begin();
  for (const Time end : ends) {
    const Time received = end + Duration::from_s(kLate_s);
    for (; next != facts.end() && (*next)->t <= received; ++next) centre.add(*next);
    if (centre.paths().empty()) continue;
    centre.end_round(end, executor);
    if (ended) ended(end);
  }
  for (; next != facts.end(); ++next) centre.add(*next);
  return centre.estimate(executor);
}

fleet::FleetEstimate estimate_facts(std::span<const ReportedByVehicle> vehicles, const MapJob& job,
                                    Executor& executor) {
  std::vector<Time> ends;
  if (job.fleet.solve == fleet::SolveWhat::kRounds) ends = round_ends(vehicles, job.rounds);
  fleet::RoundCentre centre(job.fleet, job.known);
  return estimate_by_rounds(vehicles, ends, centre, executor);
}

fleet::FleetEstimate estimate_fleet(const std::vector<VehicleRun>& runs, const MapJob& job,
                                    Executor& executor) {
  std::vector<ReportedByVehicle> reported;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Time end = runs[i].poses().empty() ? Time{} : runs[i].poses().back().t;
    reported.push_back({VehicleId{static_cast<std::uint16_t>(i)}, runs[i].facts(), end,
                        job.vehicles[i].settings.path.rest_s});
  }
  return estimate_facts(reported, job, executor);
}

}  // namespace rali::drive
