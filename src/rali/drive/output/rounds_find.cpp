#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "rali/drive/output/rounds_files.hpp"
#include "rali/fleet/rounds/anchor_choice.hpp"
#include "rali/map/explore_grid.hpp"
#include "rali/map/explore_paths.hpp"

namespace rali::drive {
namespace {

/// The frontiers of the map at a time, and the candidates for the next anchor.
struct Look {
  std::vector<map::FrontierArea> frontiers;
  std::vector<VehicleId> vehicles;  ///< FrontierArea::nearest is an index into it
  std::vector<fleet::AnchorCandidate> candidates;
};

/// The map as known at the end of each round: keyframes are added by time.
class RoundsWalk {
 public:
  RoundsWalk(const FleetRunView& fleet, const RoundsJob& job, std::vector<fleet::RoundRow> rounds,
             std::vector<fleet::Stand> stands)
      : fleet_(fleet),
        job_(job),
        rounds_(std::move(rounds)),
        stands_(std::move(stands)),
        grid_(job.grid),
        book_(job.frontiers),
        machine_(job.rounds) {
    for (const VehicleRun* run : fleet.mapped) {
      paths_.emplace_back(run->poses(), run->T_map_local());
    }
  }

  [[nodiscard]] Result<FleetRounds> run(FindingList& findings) {
    const Status walked =
        walk_keyframes(fleet_, [this](KeyframeId id, const map::KeyframeView& keyframe) {
          close_rounds_before(keyframe.t);
          fresh_ |= grid_.add(id, keyframe);
          last_ = keyframe.t;
          return Status{};
        });
    if (!walked) return tl::make_unexpected(walked.error());
    while (next_ < rounds_.size()) close_round(rounds_[next_++]);
    FleetRounds found;
    found.rounds = machine_.rounds();
    for (std::size_t i = 0; i < found.rounds.size(); ++i) found.rounds[i].frontier = deciding_[i];
    found.frontiers = machine_.frontiers();
    if (fresh_ || rounds_.empty()) add_end_of_data(found);
    if (grid_.is_full()) findings.push_back(full_finding());
    return found;
  }

 private:
  void close_rounds_before(Time t) {
    while (next_ < rounds_.size() && rounds_[next_].end && *rounds_[next_].end < t) {
      close_round(rounds_[next_++]);
    }
  }

  void close_round(const fleet::RoundRow& round) {
    machine_.anchor_began(round.anchor, round.start);
    const Time end = round.end.value_or(last_);
    see_visits(round.start, end);
    const Look look = look_at(end);
    machine_.frontiers_seen(look.frontiers, look.vehicles, true);
    machine_.anchor_ended(round.ended_by, end);
    deciding_.push_back(deciding(look, round));
  }

  /// A vehicle that comes to a standstill counts as a visit.
  void see_visits(Time start, Time end) {
    for (const fleet::Stand& stand : stands_) {
      if (stand.start < start || stand.start > end) continue;
      for (std::size_t i = 0; i < paths_.size(); ++i) {
        if (fleet_.id_of(*fleet_.mapped[i]) != stand.vehicle) continue;
        if (const auto place = paths_[i].last_known(stand.start)) book_.visited(place->p.head<2>());
      }
    }
  }

  [[nodiscard]] Look look_at(Time t) {
    fresh_ = false;
    Look look;
    const Result<map::CellMap> picture = grid_.picture();
    if (!picture) return look;  // no points yet, so there are no frontiers
    const std::vector<std::uint8_t> passable =
        map::passable_cells(*picture, job_.frontiers.radius_m);
    std::vector<map::PathField> fields;
    for (std::size_t i = 0; i < paths_.size(); ++i) {
      const auto place = paths_[i].last_known(t);
      if (!place) continue;
      look.vehicles.push_back(fleet_.id_of(*fleet_.mapped[i]));
      look.candidates.push_back({look.vehicles.back(), place->p.head<2>()});
      fields.emplace_back(*picture, passable, place->p.head<2>());
    }
    look.frontiers = map::find_frontiers(*picture, passable, fields, job_.frontiers);
    book_.name(look.frontiers);
    return look;
  }

  /// Recordings contain the users' choice of anchors: a frontier is a cause only where the rule
  /// agrees.
  [[nodiscard]] static std::optional<std::uint32_t> deciding(const Look& look,
                                                             const fleet::RoundRow& round) {
    std::vector<fleet::FrontierSpot> open;
    for (const map::FrontierArea& f : look.frontiers) {
      if (f.state == map::FrontierState::kOpen) open.push_back({f.id, f.centre_map_m, f.size});
    }
    const auto choice = fleet::nearest_to_largest(look.candidates, open);
    if (!choice || choice->vehicle != round.next_anchor) return std::nullopt;
    return open[choice->frontier].id;
  }

  /// Frontiers still open at the end of the data belong to no round.
  void add_end_of_data(FleetRounds& found) {
    fleet::RoundMachine end(job_.rounds);
    const Look look = look_at(last_);
    end.anchor_began({}, last_);
    end.frontiers_seen(look.frontiers, look.vehicles, true);
    end.end_of_data(last_);
    for (fleet::FrontierRow row : end.frontiers()) {
      row.round = 0;
      found.frontiers.push_back(std::move(row));
    }
  }

  [[nodiscard]] Finding full_finding() const {
    Finding f;
    f.id = "fleet.frontier_grid_full";
    f.text = fmt::format("the grid for frontiers has more than {:.0f} cells", job_.grid.cells_max);
    f.effect = "frontiers.csv covers a part of the map only";
    return f;
  }

  const FleetRunView& fleet_;
  const RoundsJob& job_;
  std::vector<fleet::RoundRow> rounds_;
  std::vector<fleet::Stand> stands_;
  std::vector<FinalPath> paths_;  ///< of fleet_.mapped
  map::ExploreGrid grid_;
  map::FrontierBook book_;
  fleet::RoundMachine machine_;
  std::vector<std::optional<std::uint32_t>> deciding_;
  std::size_t next_ = 0;  ///< round to be closed
  bool fresh_ = false;    ///< keyframes came since the last search
  Time last_;
};

/// A table whose rounds lie outside of the data uses another clock.
void check_table(const FleetRunView& fleet, const std::vector<fleet::RoundRow>& rounds,
                 FindingList& findings) {
  if (rounds.empty()) return;
  for (const VehicleRun& run : *fleet.runs) {
    if (run.poses().empty()) continue;
    const Time begin = run.poses().front().t, end = run.poses().back().t;
    for (const fleet::RoundRow& r : rounds) {
      if (r.start <= end && begin <= r.end.value_or(end)) return;
    }
  }
  Finding f;
  f.id = "fleet.rounds_elsewhere";
  f.text = "no round of the table lies within the recordings";
  f.effect = "it has no frontiers of them";
  f.remedy = "Give start_s and end_s as the recordings stamp their data.";
  findings.push_back(f);
}

}  // namespace

Result<FleetRounds> find_rounds(const FleetRunView& fleet, const RoundsJob& job,
                                std::span<const double> rest_s, FindingList& findings) {
  findings.insert(findings.end(), job.findings.begin(), job.findings.end());
  std::vector<fleet::Stand> stands;
  for (std::size_t v = 0; v < fleet.runs->size(); ++v) {
    const VehicleRun& run = (*fleet.runs)[v];
    if (run.poses().empty()) continue;
    const auto own = stands_of(fleet.id_of(run), run.facts(), run.poses().back().t, rest_s[v],
                               job.rounds.stand_min_s);
    stands.insert(stands.end(), own.begin(), own.end());
  }
  std::vector<fleet::RoundRow> rounds;
  if (job.from == RoundsFrom::kTable) {
    Result<std::vector<fleet::RoundRow>> table = fleet::rounds_of_table(job.table);
    if (!table) return tl::make_unexpected(table.error());
    rounds = std::move(*table);
    check_table(fleet, rounds, findings);
  } else {
    rounds = fleet::rounds_of_stands(stands, job.rounds.stand_min_s);
    judge_ends(fleet, job, rounds);
  }
  return RoundsWalk(fleet, job, std::move(rounds), std::move(stands)).run(findings);
}

}  // namespace rali::drive
