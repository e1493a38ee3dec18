#include <algorithm>
#include <cmath>
#include <optional>

#include "rali/drive/output/rounds_files.hpp"
#include "rali/fleet/rounds/finish.hpp"

namespace rali::drive {
namespace {

constexpr double kMark_s = 1.0;       ///< between marks of one standstill
constexpr double kNodeLate_s = 1.0;   ///< a node may come this much after its time
constexpr double kEndOfData_s = 2.0;  ///< a standstill until then lasts to the end

struct Node {
  Time t;
  bool at_rest = false, degenerate = false;
};

/// The facts that rounds depend on, by time.
struct Reported {
  std::vector<Node> nodes;
  std::vector<fleet::RangeEntry> ranges;
};

Reported reported_by(std::span<const std::shared_ptr<const fleet::Fact>> facts) {
  Reported reported;
  for (const auto& fact : facts) {
    if (const auto* step = std::get_if<fleet::Increment>(&fact->body)) {
      reported.nodes.push_back({fact->t, step->at_rest, step->degenerate});
    } else if (const auto* block = std::get_if<fleet::RangeBlock>(&fact->body)) {
      reported.ranges.insert(reported.ranges.end(), block->ranges.begin(), block->ranges.end());
    }
  }
  const auto earlier = [](const auto& a, const auto& b) { return a.t < b.t; };
  std::stable_sort(reported.nodes.begin(), reported.nodes.end(), earlier);
  std::stable_sort(reported.ranges.begin(), reported.ranges.end(), earlier);
  return reported;
}

/// Decides whether one tag finishes in one round before the anchor leaves.
class TagWatch {
 public:
  TagWatch(VehicleId tag, VehicleId anchor, const Reported& reported, const FinalPath& tag_path,
           const FinalPath& anchor_path, const RoundsJob& job)
      : tag_(tag),
        anchor_(anchor),
        reported_(reported),
        tag_path_(tag_path),
        anchor_path_(anchor_path),
        job_(job),
        watch_(job.rounds.finish) {}

  [[nodiscard]] fleet::FinishReason at_end(Time start, Time end) {
    watch_.new_round(start);
    std::size_t node = 0;
    auto range = std::lower_bound(reported_.ranges.begin(), reported_.ranges.end(), start,
                                  [](const auto& r, Time t) { return r.t < t; });
    auto radio = std::lower_bound(job_.radio.begin(), job_.radio.end(), start,
                                  [](const auto& r, Time t) { return r.t < t; });
    fleet::FinishReason reason = fleet::FinishReason::kNone;
    const Duration step = Duration::from_s(kStep_s);
    for (Time t = start + step; t <= end; t = t + step) {
      fleet::FinishInput input;
      input.t = t;
      while (node + 1 < reported_.nodes.size() && reported_.nodes[node + 1].t <= t) ++node;
      if (node < reported_.nodes.size()) {
        input.moves = !reported_.nodes[node].at_rest;
        input.degenerate = reported_.nodes[node].degenerate;
      }
      for (; range != reported_.ranges.end() && range->t <= t; ++range) {
        if (range->from == anchor_ || range->to == anchor_) input.range_m = range->range_m;
      }
      for (; radio != job_.radio.end() && radio->t <= t; ++radio) {
        if (joins(*radio)) input.rssi_dbm = radio->rssi_dbm;
      }
      take_places(input);
      reason = watch_.step(input).reason;
    }
    return reason;
  }

 private:
  static constexpr double kStep_s = 0.5;

  /// A link has equal strength in both directions; the tag's own packets are equivalent.
  [[nodiscard]] bool joins(const sensor::RadioSample& s) const {
    return (s.from == anchor_ && s.to == tag_) || (s.from == tag_ && s.to == anchor_);
  }

  void take_places(fleet::FinishInput& input) const {
    const auto here = tag_path_.last_known(input.t), there = anchor_path_.last_known(input.t);
    if (here && there) input.distance_m = (here->p - there->p).norm();
    const PoseRecord* pose = tag_path_.before(input.t);
    if (pose != nullptr && pose->degenerate) input.sigma_m = pose->sigma_degenerate_m;
  }

  VehicleId tag_, anchor_;
  const Reported& reported_;
  const FinalPath& tag_path_;
  const FinalPath& anchor_path_;
  const RoundsJob& job_;
  fleet::FinishWatch watch_;
};

}  // namespace

std::vector<fleet::Stand> stands_of(VehicleId vehicle,
                                    std::span<const std::shared_ptr<const fleet::Fact>> facts,
                                    Time data_end, double rest_s, double stand_min_s) {
  const std::vector<Node> nodes = reported_by(facts).nodes;
  fleet::StandFinder finder(vehicle, stand_min_s);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    finder.add(nodes[i].t, nodes[i].at_rest);
    if (!nodes[i].at_rest) continue;
    // Nothing changes until the next node or the end, unless that is overdue.
    const Time until = i + 1 < nodes.size() ? nodes[i + 1].t : data_end;
    const double gap_s = seconds_between(nodes[i].t, until);
    if (gap_s > rest_s + kNodeLate_s) continue;
    for (double s = kMark_s; s < gap_s; s += kMark_s) {
      finder.add(nodes[i].t + Duration::from_s(s), true);
    }
    if (until > nodes[i].t) finder.add(until, true);
  }
  return finder.stands();
}

void judge_ends(const FleetRunView& fleet, const RoundsJob& job,
                std::vector<fleet::RoundRow>& rounds) {
  std::vector<Reported> reported;
  std::vector<FinalPath> paths;
  for (const VehicleRun& run : *fleet.runs) {
    reported.push_back(reported_by(run.facts()));
    paths.emplace_back(run.poses(), run.T_map_local());
  }
  for (fleet::RoundRow& round : rounds) {
    if (!round.end) continue;
    const std::vector<PoseRecord>& poses = (*fleet.runs)[round.anchor.value].poses();
    if (!poses.empty() && seconds_between(*round.end, poses.back().t) < kEndOfData_s) {
      round.ended_by = fleet::RoundEnd::kEndOfData;
      continue;
    }
    bool all = fleet.runs->size() > 1;
    for (std::size_t v = 0; all && v < fleet.runs->size(); ++v) {
      const VehicleId tag{static_cast<std::uint16_t>(v)};
      if (tag == round.anchor) continue;
      TagWatch watch(tag, round.anchor, reported[v], paths[v], paths[round.anchor.value], job);
      all = watch.at_end(round.start, *round.end) != fleet::FinishReason::kNone;
    }
    if (all) round.ended_by = fleet::RoundEnd::kFinished;
  }
}

}  // namespace rali::drive
