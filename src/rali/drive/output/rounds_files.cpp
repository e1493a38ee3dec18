#include "rali/drive/output/rounds_files.hpp"

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/csv_writer.hpp"
#include "rali/io/files/text.hpp"

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

std::string name_of(const FleetRunView& fleet, std::optional<VehicleId> id) {
  return id && id->value < fleet.runs->size() ? (*fleet.runs)[id->value].name() : std::string();
}

std::string rounds_text(const FleetRunView& fleet, const std::vector<fleet::RoundRow>& rounds) {
  std::string text = "round,anchor,start_s,end_s,ended_by,next_anchor,frontier_id\n";
  for (const fleet::RoundRow& r : rounds) {
    io::CsvRow row;
    row.integer(r.round).text(name_of(fleet, r.anchor)).stamp(r.start);
    r.end ? row.stamp(*r.end) : row.empty();
    row.text(fleet::name_of(r.ended_by)).text(name_of(fleet, r.next_anchor));
    r.frontier ? row.integer(*r.frontier) : row.empty();
    text += row.line() + '\n';
  }
  return text;
}

std::string frontiers_text(const FleetRunView& fleet,
                           const std::vector<fleet::FrontierRow>& frontiers) {
  std::string text = "round,id,x,y,length_m,nearest_vehicle,state,reason\n";
  for (const fleet::FrontierRow& f : frontiers) {
    io::CsvRow row;
    row.integer(f.round).integer(f.id).fixed(f.x_m, 3).fixed(f.y_m, 3).fixed(f.length_m, 2);
    row.text(name_of(fleet, f.nearest_vehicle)).text(fleet::name_of(f.state)).text(f.reason);
    text += row.line() + '\n';
  }
  return text;
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
    const auto stream = keyframe_stream(fleet.out_dir, one, at.run->T_map_odom());
    const Status read =
        stream([&](const map::KeyframeView& view) { visited = visit(at.record->id, view); });
    if (!read) return read;
    if (!visited) return visited;
  }
  return {};
}

Status write_rounds_files(const FleetRunView& fleet, const FleetRounds& rounds) {
  const Status status =
      io::write_file_atomic(fleet.out_dir + "/rounds.csv", rounds_text(fleet, rounds.rounds));
  if (!status) return status;
  return io::write_file_atomic(fleet.out_dir + "/frontiers.csv",
                               frontiers_text(fleet, rounds.frontiers));
}

}  // namespace rali::drive
