#include "rali/drive/output/rounds_table.hpp"

#include <optional>

#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/csv_writer.hpp"

namespace rali::drive {
namespace {

using Names = std::vector<std::string>;

std::string name_of(const Names& names, std::optional<VehicleId> id) {
  return id && id->value < names.size() ? names[id->value] : std::string();
}

std::string rounds_text(const Names& names, const std::vector<fleet::RoundRow>& rounds) {
  std::string text = "round,anchor,start_s,end_s,ended_by,next_anchor,frontier_id\n";
  for (const fleet::RoundRow& r : rounds) {
    io::CsvRow row;
    row.integer(r.round).text(name_of(names, r.anchor)).stamp(r.start);
    r.end ? row.stamp(*r.end) : row.empty();
    row.text(fleet::name_of(r.ended_by)).text(name_of(names, r.next_anchor));
    r.frontier ? row.integer(*r.frontier) : row.empty();
    text += row.line() + '\n';
  }
  return text;
}

std::string frontiers_text(const Names& names, const std::vector<fleet::FrontierRow>& frontiers) {
  std::string text = "round,id,x,y,length_m,nearest_vehicle,state,reason\n";
  for (const fleet::FrontierRow& f : frontiers) {
    io::CsvRow row;
    row.integer(f.round).integer(f.id).fixed(f.x_m, 3).fixed(f.y_m, 3).fixed(f.length_m, 2);
    row.text(name_of(names, f.nearest_vehicle)).text(fleet::name_of(f.state)).text(f.reason);
    text += row.line() + '\n';
  }
  return text;
}

}  // namespace

Status write_rounds_table(const std::string& folder, const std::vector<std::string>& names,
                          const std::vector<fleet::RoundRow>& rounds,
                          const std::vector<fleet::FrontierRow>& frontiers) {
  const Status status = io::write_file_atomic(folder + "/rounds.csv", rounds_text(names, rounds));
  if (!status) return status;
  return io::write_file_atomic(folder + "/frontiers.csv", frontiers_text(names, frontiers));
}

}  // namespace rali::drive
