#include "rali/drive/output/rounds_files.hpp"

#include <algorithm>
#include <tuple>

#include "rali/drive/output/rounds_table.hpp"

namespace rali::drive {
namespace {

struct KeyframeAt {
  const VehicleRun* run = nullptr;
  const KeyframeRecord* record = nullptr;
};

std::vector<KeyframeAt> keyframes_by_time(const FleetRunView& fleet) {
  std::vector<KeyframeAt> keyframes;
  for (const VehicleRun* run : fleet.mapped) {
    for (const KeyframeRecord& record : run->keyframes()) {
      if (!record.diverged) keyframes.push_back({run, &record});
    }
  }
  std::sort(keyframes.begin(), keyframes.end(), [](const KeyframeAt& a, const KeyframeAt& b) {
    return std::tuple(a.record->t, a.record->id) < std::tuple(b.record->t, b.record->id);
  });
  return keyframes;
}

}  // namespace

std::vector<const VehicleRun*> mapped_runs(const std::vector<VehicleRun>& runs,
                                           const fleet::FleetEstimate& estimate) {
  for (const std::vector<VehicleId>& group : estimate.groups) {
    std::vector<const VehicleRun*> mapped;
    for (const VehicleId id : group) {
      const VehicleRun& run = runs[id.value];
      const bool any = std::any_of(run.keyframes().begin(), run.keyframes().end(),
                                   [](const KeyframeRecord& k) { return !k.diverged; });
      if (any) mapped.push_back(&run);
    }
    if (!mapped.empty()) return mapped;
  }
  return {};
}

Status walk_keyframes(const FleetRunView& fleet, const KeyframeByTime& visit) {
  for (const KeyframeAt& at : keyframes_by_time(fleet)) {
    const std::vector<KeyframeRecord> one{*at.record};
    Status visited;
    const auto stream = keyframe_stream(fleet.out_dir, one, at.run->T_map_local());
    const Status read =
        stream([&](const map::KeyframeView& view) { visited = visit(at.record->id, view); });
    if (!read) return read;
    if (!visited) return visited;
  }
  return {};
}

Status write_rounds_files(const FleetRunView& fleet, const FleetRounds& rounds) {
  std::vector<std::string> names;
  for (const VehicleRun& run : *fleet.runs) names.push_back(run.name());
  return write_rounds_table(fleet.out_dir, names, rounds.rounds, rounds.frontiers);
}

}  // namespace rali::drive
