#include "rali/drive/output/rounds_input.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/text.hpp"

namespace rali::drive {
namespace {

constexpr std::size_t kRoundsMax = 100'000;

Result<Time> stamp_of(const io::CsvReader& csv, int column, const char* name) {
  if (const std::optional<Time> t = io::parse_stamp(csv.cell(column))) return *t;
  return fail(ErrorCode::kInput, csv.where(),
              fmt::format("{} is {}, not a time in seconds", name, io::quoted(csv.cell(column))),
              "Give stamps as they are in the recordings.");
}

Result<VehicleId> anchor_of(const io::CsvReader& csv, int column, const io::RadioNames& names) {
  const auto found = names.find(csv.cell(column));
  if (found != names.end()) return found->second.vehicle;
  return fail(ErrorCode::kInput, csv.where(),
              fmt::format("the anchor {} is no vehicle of the fleet", io::quoted(csv.cell(column))),
              "Use the names under `vehicles`.");
}

Result<std::vector<fleet::Stand>> rounds_from(Result<io::CsvReader> csv,
                                              const io::RadioNames& names) {
  if (!csv) return tl::make_unexpected(csv.error());
  const Result<int> anchor = csv->require("anchor");
  if (!anchor) return tl::make_unexpected(anchor.error());
  const Result<int> start = csv->require("start_s");
  if (!start) return tl::make_unexpected(start.error());
  const Result<int> end = csv->require("end_s");
  if (!end) return tl::make_unexpected(end.error());
  std::vector<fleet::Stand> table;
  for (;;) {
    const Result<bool> more = csv->next();
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) break;
    const Result<VehicleId> who = anchor_of(*csv, *anchor, names);
    if (!who) return tl::make_unexpected(who.error());
    const Result<Time> from = stamp_of(*csv, *start, "start_s");
    if (!from) return tl::make_unexpected(from.error());
    const Result<Time> to = stamp_of(*csv, *end, "end_s");
    if (!to) return tl::make_unexpected(to.error());
    if (table.size() == kRoundsMax) {
      return fail(ErrorCode::kInput, csv->where(), "more than 100000 rounds", "");
    }
    table.push_back({*who, *from, *to});
    // Together with the preceding row: an error then belongs to this row, at any position.
    const std::size_t last = std::min<std::size_t>(table.size(), 2);
    const auto checked = fleet::rounds_of_table({table.data() + table.size() - last, last});
    if (!checked) {
      const Error& error = checked.error();
      return fail(error.code, csv->where(), error.what, error.remedy);
    }
  }
  return table;
}

}  // namespace

Result<std::vector<fleet::Stand>> read_rounds_csv(const std::string& path,
                                                  const io::RadioNames& names) {
  return rounds_from(io::CsvReader::open(path), names);
}

Result<std::vector<fleet::Stand>> parse_rounds_csv(std::string text, const std::string& name,
                                                   const io::RadioNames& names) {
  return rounds_from(io::CsvReader::from_text(std::move(text), name), names);
}

Status read_radio(const std::string& path, const io::RadioNames& names, RoundsJob& job) {
  Result<io::RadioCsv> csv = io::read_radio_csv(path, names);
  if (!csv) return tl::make_unexpected(csv.error());
  std::stable_sort(csv->samples.begin(), csv->samples.end(),
                   [](const auto& a, const auto& b) { return a.t < b.t; });
  job.radio = std::move(csv->samples);
  for (Finding& f : csv->findings) job.findings.push_back(std::move(f));
  return {};
}

}  // namespace rali::drive
