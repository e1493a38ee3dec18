#include "rali/drive/closed_loop/mission_files.hpp"

#include "rali/io/files/csv_writer.hpp"

namespace rali::drive {
namespace {

void add_name(io::CsvRow& row, const std::optional<VehicleId>& vehicle,
              const std::vector<std::string>& names) {
  if (vehicle && vehicle->value < names.size()) {
    row.text(names[vehicle->value]);
  } else {
    row.empty();
  }
}

Status write_rounds(const std::string& path, const MissionLog& log,
                    const std::vector<std::string>& names) {
  auto file = io::CsvWriter::create(
      path, {"round", "anchor", "start_s", "end_s", "ended_by", "next_anchor", "frontier_id"});
  if (!file) return tl::make_unexpected(file.error());
  for (const fleet::RoundRow& r : log.rounds) {
    io::CsvRow row;
    row.integer(r.round);
    add_name(row, r.anchor, names);
    row.stamp(r.start);
    r.end ? row.stamp(*r.end) : row.empty();
    row.text(name_of(r.ended_by));
    add_name(row, r.next_anchor, names);
    r.frontier ? row.integer(*r.frontier) : row.empty();
    if (Status s = file->add(row); !s) return s;
  }
  return file->finish();
}

Status write_frontiers(const std::string& path, const MissionLog& log,
                       const std::vector<std::string>& names) {
  auto file = io::CsvWriter::create(
      path, {"round", "id", "x", "y", "length_m", "nearest_vehicle", "state", "reason"});
  if (!file) return tl::make_unexpected(file.error());
  for (const fleet::FrontierRow& f : log.frontiers) {
    io::CsvRow row;
    row.integer(f.round).integer(f.id).fixed(f.x_m, 3).fixed(f.y_m, 3).fixed(f.length_m, 2);
    add_name(row, f.nearest_vehicle, names);
    row.text(fleet::name_of(f.state)).text(f.reason);
    if (Status s = file->add(row); !s) return s;
  }
  return file->finish();
}

}  // namespace

Status write_mission_files(const std::string& folder, const MissionLog& log,
                           const std::vector<std::string>& names) {
  if (Status s = write_rounds(folder + "/rounds.csv", log, names); !s) return s;
  return write_frontiers(folder + "/frontiers.csv", log, names);
}

}  // namespace rali::drive
