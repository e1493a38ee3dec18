#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/base/finding_of.hpp"
#include "rali/drive/fact_path.hpp"
#include "rali/fleet/facts/keyframe_number.hpp"

namespace rali::drive {
namespace {

using fleet::FleetEstimate;
using fleet::VehicleFrame;

/// Number of nodes of each start of a vehicle, by epoch.
std::map<std::uint32_t, std::size_t> lengths_of(const FleetFacts::Member& member) {
  std::map<std::uint32_t, std::size_t> nodes;
  for (const fleet::FactPtr& fact : member.facts) {
    if (std::holds_alternative<fleet::Increment>(fact->body)) ++nodes[fact->key.epoch];
  }
  return nodes;
}

class OneFrameEach {
 public:
  OneFrameEach(const FleetFacts& facts, FleetEstimate& estimate, FindingList& findings)
      : facts_(facts), estimate_(estimate), findings_(findings) {}

  std::vector<StartFrames> run() {
    std::vector<StartFrames> kept(facts_.members.size());
    for (std::size_t v = 0; v < kept.size(); ++v) keep(v, kept[v]);
    drop_frames();
    drop_keyframes(kept);
    renew_groups();
    return kept;
  }

 private:
  [[nodiscard]] std::size_t size_of(const VehicleFrame& frame) const {
    return estimate_.groups[frame.group].size();
  }

  /// The start that defines the frame of the vehicle's results; null without a path.
  [[nodiscard]] const VehicleFrame* home_of(std::size_t vehicle) const {
    const auto lengths = lengths_of(facts_.members[vehicle]);
    const VehicleFrame* home = nullptr;
    for (const VehicleFrame& frame : estimate_.frames) {
      if (frame.vehicle.value != vehicle) continue;
      const bool larger = home != nullptr && size_of(frame) > size_of(*home);
      const bool longer = home != nullptr && frame.group != home->group &&
                          size_of(frame) == size_of(*home) &&
                          lengths.at(frame.epoch) > lengths.at(home->epoch);
      if (home == nullptr || larger || longer) home = &frame;
    }
    return home;
  }

  void keep(std::size_t vehicle, StartFrames& kept) {
    const VehicleFrame* home = home_of(vehicle);
    if (home == nullptr) return;
    homes_.insert({home->vehicle, home->epoch});
    for (const VehicleFrame& frame : estimate_.frames) {
      if (frame.vehicle != home->vehicle) continue;
      if (&frame == home) {
        kept[frame.epoch] = {};
      } else if (frame.group == home->group) {
        kept[frame.epoch] = home->T_map_odom.inverse() * frame.T_map_odom;
      } else {
        report_left_out(frame);
      }
    }
  }

  void report_left_out(const VehicleFrame& frame) {
    const auto& member = facts_.members[frame.vehicle.value];
    Finding f = finding_of(
        "state.start_left_out", Severity::kWarning,
        fmt::format("start {} with {} is not joined to the rest of its path", frame.epoch + 1,
                    counted(lengths_of(member).at(frame.epoch), "pose")),
        "it is in no result");
    if (!frame.waits_for.empty()) f.text += ": " + frame.waits_for;
    f.vehicle = member.name;
    findings_.push_back(std::move(f));
  }

  void drop_frames() {
    std::erase_if(estimate_.frames, [&](const VehicleFrame& frame) {
      return !homes_.contains({frame.vehicle, frame.epoch});
    });
  }

  void drop_keyframes(const std::vector<StartFrames>& kept) {
    const auto left_out = [&](KeyframeId id) {
      return !kept[id.vehicle.value].contains(fleet::epoch_of_keyframe(id.seq));
    };
    std::erase_if(estimate_.keyframes, [&](const auto& entry) { return left_out(entry.first); });
    std::erase_if(estimate_.loops, [&](const fleet::LoopVerdict& loop) {
      return left_out(loop.from) || left_out(loop.to);
    });
  }

  /// Each vehicle once, in the group of its frame.
  void renew_groups() {
    std::vector<std::vector<VehicleId>> groups(estimate_.groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g) {
      for (const VehicleId id : estimate_.groups[g]) {
        const bool at_home =
            std::any_of(estimate_.frames.begin(), estimate_.frames.end(),
                        [&](const VehicleFrame& f) { return f.vehicle == id && f.group == g; });
        const bool known = std::find(groups[g].begin(), groups[g].end(), id) != groups[g].end();
        if (at_home && !known) groups[g].push_back(id);
      }
    }
    std::vector<std::size_t> order;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (!groups[g].empty()) order.push_back(g);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return groups[a].size() > groups[b].size();
    });
    std::vector<std::size_t> place(groups.size(), 0);
    estimate_.groups.clear();
    for (const std::size_t g : order) {
      place[g] = estimate_.groups.size();
      estimate_.groups.push_back(std::move(groups[g]));
    }
    for (VehicleFrame& frame : estimate_.frames) frame.group = place[frame.group];
  }

  const FleetFacts& facts_;
  FleetEstimate& estimate_;
  FindingList& findings_;
  std::set<std::pair<VehicleId, std::uint32_t>> homes_;
};

}  // namespace

std::vector<StartFrames> keep_one_frame_each(const FleetFacts& facts, FleetEstimate& estimate,
                                             FindingList& findings) {
  return OneFrameEach(facts, estimate, findings).run();
}

FindingList missing_findings(const FleetFacts& facts) {
  FindingList findings;
  for (const FleetFacts::Member& member : facts.members) {
    if (member.missing == 0) continue;
    Finding f = finding_of("state.missing", Severity::kWarning,
                           fmt::format("{} of {} are in no folder", member.missing,
                                       counted(member.facts.size() + member.missing, "fact")),
                           "the map lacks what they hold",
                           "Give the state folders of the other vehicles, too.");
    f.vehicle = member.name;
    findings.push_back(std::move(f));
  }
  return findings;
}

}  // namespace rali::drive
