#include "rali/jobs/input_checks.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <span>

#include <fmt/format.h>

#include "rali/drive/ranges/serial_log.hpp"
#include "rali/io/files/csv_reader.hpp"
#include "rali/io/input_kind.hpp"

namespace rali::jobs {
namespace {

using config::FleetConfig;

/// A file named in the settings must exist and be readable before any computation.
Status check_file(const FleetConfig& fleet, const std::string& key, const std::string& path) {
  if (path.empty()) return {};
  const std::string named = origin_of(fleet, key);
  const std::string remedy =
      named == "command line" || named == key ? "" : fmt::format("It is named at {}.", named);
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return fail(ErrorCode::kInput, path, "there is no such file", remedy);
  }
  if (std::filesystem::is_directory(path, error)) {
    return fail(ErrorCode::kInput, path, "is a folder, not a file", remedy);
  }
  if (!std::ifstream(path)) return fail(ErrorCode::kInput, path, "cannot be read", remedy);
  return {};
}

/// The columns that a CSV must have; its rows are checked where they are used.
Status check_columns(const std::string& path, std::span<const char* const> columns) {
  if (path.empty()) return {};
  const Result<io::CsvReader> csv = io::CsvReader::open(path);
  if (!csv) return tl::make_unexpected(csv.error());
  for (const char* const column : columns) {
    const Result<int> found = csv->require(column);
    if (!found) return tl::make_unexpected(found.error());
  }
  return {};
}

}  // namespace

Status check_side_files(const FleetConfig& fleet) {
  constexpr std::array<const char*, 4> kRangeColumns = {"stamp_s", "from", "to", "range_m"};
  constexpr std::array<const char*, 2> kSerialColumns = {"stamp_s", "hex"};
  constexpr std::array<const char*, 4> kRadioColumns = {"stamp_s", "from", "to", "rssi_dbm"};
  for (const config::RangeSource& source : fleet.ranges.sources) {
    for (const std::string& path : {source.file, source.serial_log}) {
      if (Status s = check_file(fleet, "ranges.sources", path); !s) return s;
    }
    if (Status s = check_columns(source.file, kRangeColumns); !s) return s;
    if (Status s = check_columns(source.serial_log, kSerialColumns); !s) {
      s.error().remedy = drive::kSerialLogFormat;
      return s;
    }
  }
  if (Status s = check_file(fleet, "radio.file", fleet.radio_file); !s) return s;
  if (Status s = check_columns(fleet.radio_file, kRadioColumns); !s) return s;
  if (Status s = check_file(fleet, "output.georeference", fleet.output.georeference); !s) return s;
  const bool file = fleet.rounds != "auto" && fleet.rounds != "off";
  return file ? check_file(fleet, "rounds", fleet.rounds) : Status{};
}

std::string origin_of(const FleetConfig& fleet, const std::string& key) {
  const auto origin = fleet.origins.find(key);
  return origin == fleet.origins.end() ? key : origin->second;
}

Status check_recordings(const FleetConfig& fleet) {
  for (const config::VehicleConfig& vehicle : fleet.vehicles) {
    for (const std::string& recording : vehicle.recordings) {
      const Result<io::InputKind> kind = io::input_kind(recording);
      if (kind) continue;
      Error error = kind.error();
      const auto origin = fleet.origins.find("vehicles." + vehicle.name + ".recording");
      const bool typed = origin == fleet.origins.end() || origin->second == "command line";
      if (!typed && error.remedy.empty()) {
        error.remedy = fmt::format("It is named at {}.", origin->second);
      }
      return tl::make_unexpected(std::move(error));
    }
  }
  return {};
}

}  // namespace rali::jobs
