#include "rali/io/files/old_names.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include <fmt/core.h>

#include "rali/io/files/csv_reader.hpp"

namespace rali::io {
namespace {

namespace fs = std::filesystem;

struct Renamed {
  std::string_view old_name, name;
};

constexpr std::array kRenamed{
    // metrics.json
    Renamed{"t_begin_s", "t_start_s"},
    Renamed{"sweeps", "scans"},
    Renamed{"sweeps_dropped", "scans_dropped"},
    Renamed{"blind_share", "degenerate_fraction"},
    Renamed{"blind_held_share", "degenerate_constrained_fraction"},
    // degeneracy/<v>.csv; the first also in evaluation.json
    Renamed{"blind", "degenerate"},
    Renamed{"sigma_blind_m", "sigma_degenerate_m"},
    Renamed{"held_by", "constrained_by"},
    // errors/<v>.csv, evaluation.json and its limits
    Renamed{"along_blind_m", "along_degenerate_m"},
    Renamed{"along_blind_rmse_m", "along_degenerate_rmse_m"},
    Renamed{"time_share", "time_fraction"},
    Renamed{"way_m", "distance_m"},
    Renamed{"way_share", "distance_fraction"},
    Renamed{"share_within_95", "fraction_within_95"},
    Renamed{"share_beyond_cut", "fraction_beyond_cut"},
    Renamed{"open_directions", "degenerate_directions"},
};

/// Whether one of this program's documents has the schema of version 0.1; the number is near its
/// start.
bool has_old_schema(const std::string& path) {
  std::array<char, 512> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  const std::string_view text(head.data(), static_cast<std::size_t>(file.gcount()));
  return text.find("\"schema\": 1,") != std::string_view::npos;
}

bool has_old_column(const std::string& path) {
  const Result<CsvReader> csv = CsvReader::open(path);
  if (!csv) return false;
  return std::any_of(csv->header().begin(), csv->header().end(),
                     [](const std::string& name) { return current_name_of(name) != name; });
}

/// Whether a table of the folder has old column names.
bool has_old_table(const std::string& folder) {
  std::error_code error;
  fs::directory_iterator it(folder, error);
  for (; !error && it != fs::directory_iterator(); it.increment(error)) {
    if (it->path().extension() == ".csv" && has_old_column(it->path().string())) return true;
  }
  return false;
}

}  // namespace

std::string_view old_name_of(std::string_view name) {
  const auto* const at = std::find_if(kRenamed.begin(), kRenamed.end(),
                                      [&](const Renamed& r) { return r.name == name; });
  return at == kRenamed.end() ? std::string_view() : at->old_name;
}

std::string_view current_name_of(std::string_view name) {
  const auto* const at = std::find_if(kRenamed.begin(), kRenamed.end(),
                                      [&](const Renamed& r) { return r.old_name == name; });
  return at == kRenamed.end() ? name : at->name;
}

std::vector<std::string> notices_of_old_names(const std::string& out_dir) {
  std::vector<std::string> notices;
  const auto add = [&](std::string_view file, std::string_view command) {
    notices.push_back(fmt::format(
        "{}/{}: keys or columns have the names of version 0.1, which this release still reads. "
        "Run {} again to renew them",
        out_dir, file, command));
  };
  if (has_old_schema(out_dir + "/metrics.json")) add("metrics.json", "rali map");
  if (has_old_table(out_dir + "/degeneracy")) add("degeneracy/*.csv", "rali map");
  if (has_old_schema(out_dir + "/evaluation.json")) add("evaluation.json", "rali evaluate");
  if (has_old_table(out_dir + "/errors")) add("errors/*.csv", "rali evaluate");
  return notices;
}

}  // namespace rali::io
