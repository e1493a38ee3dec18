#include "rali/io/files/range_csv.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/core.h>

#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

constexpr std::size_t kUnknownNamesMax = 100;
constexpr std::array<std::string_view, 9> kRangeColumns = {
    "stamp_s",        "from",         "to",         "range_m", "rssi_dbm",
    "first_path_dbm", "from_antenna", "to_antenna", "sigma_m"};
constexpr std::array<std::string_view, 4> kRadioColumns = {"stamp_s", "from", "to", "rssi_dbm"};

/// One row's link: the common part of ranges.csv and radio.csv.
struct Link {
  Time t;
  RadioEnd from, to;
};

/// Reads rows with a radio at each end.
class LinkReader {
 public:
  LinkReader(CsvReader csv, std::string name, const RadioNames& names)
      : csv_(std::move(csv)), name_(std::move(name)), names_(names) {}

  Status require(std::string_view value_column) {
    const std::pair<std::string_view, int*> wanted[] = {
        {"stamp_s", &stamp_}, {"from", &from_}, {"to", &to_}, {value_column, &value_}};
    for (const auto& [column, index] : wanted) {
      const auto found = csv_.require(column);
      if (!found) return tl::make_unexpected(found.error());
      *index = *found;
    }
    from_antenna_ = csv_.column("from_antenna");
    to_antenna_ = csv_.column("to_antenna");
    return {};
  }

  /// True: a usable row; false: end.
  Result<bool> next(Link& link, double& value) {
    while (true) {
      auto more = csv_.next();
      if (!more || !*more) return more;
      ++stats_.rows;
      if (take_row(link, value)) return true;
    }
  }

  /// A cell that may be empty or missing; a non-finite number counts as unknown.
  double optional_number(int column) const {
    const auto number = parse_number(csv_.cell(column));
    return number && std::isfinite(*number) ? *number : 0.0;
  }

  [[nodiscard]] const CsvReader& csv() const { return csv_; }

  [[nodiscard]] const RadioCsvStats& stats() const { return stats_; }

  template <std::size_t N>
  [[nodiscard]] FindingList findings(const std::array<std::string_view, N>& known_columns) const;

  [[nodiscard]] std::string known_names() const {
    std::string list;
    for (const auto& [name, end] : names_) list += (list.empty() ? "" : ", ") + name;
    return list;
  }

 private:
  bool take_row(Link& link, double& value) {
    if (!csv_.complete()) return bad("has more or fewer cells than the header");
    const auto t = parse_stamp(csv_.cell(stamp_));
    if (!t) return bad(quoted(csv_.cell(stamp_)) + " is no stamp in seconds");
    const auto number = parse_number(csv_.cell(value_));
    if (!number || !std::isfinite(*number)) {
      return bad(quoted(csv_.cell(value_)) + " is no finite number");
    }
    const auto from = end_of(csv_.cell(from_), csv_.cell(from_antenna_));
    const auto to = end_of(csv_.cell(to_), csv_.cell(to_antenna_));
    if (!from || !to) {
      ++stats_.unknown_rows;
      return false;
    }
    if (from->vehicle == to->vehicle) {
      ++stats_.self_rows;
      return false;
    }
    link = {*t, *from, *to};
    value = *number;
    return true;
  }

  bool bad(std::string reason) {
    if (stats_.bad_rows++ == 0) {
      stats_.first_bad_line = csv_.line();
      stats_.first_bad_reason = std::move(reason);
    }
    return false;
  }

  std::optional<RadioEnd> end_of(std::string_view vehicle, std::string_view antenna) {
    std::string name(vehicle);
    const auto index = parse_integer(antenna);
    if (!antenna.empty() && !index) name += "/" + std::string(antenna);
    const auto found = names_.find(name);
    const bool index_fits = !index || (*index >= 0 && *index <= 255);
    if (found == names_.end() || !index_fits) {
      if (!index_fits) name += "/" + std::string(antenna);
      count_unknown(name);
      return std::nullopt;
    }
    RadioEnd end = found->second;
    if (index) end.antenna = static_cast<std::uint8_t>(*index);
    return end;
  }

  void count_unknown(const std::string& name) {
    const auto found = stats_.unknown.find(name);
    if (found != stats_.unknown.end()) {
      ++found->second.rows;
    } else if (stats_.unknown.size() < kUnknownNamesMax) {
      stats_.unknown[name] = {1, csv_.line()};
    }
  }

  CsvReader csv_;
  std::string name_;
  const RadioNames& names_;
  int stamp_ = -1, from_ = -1, to_ = -1, value_ = -1, from_antenna_ = -1, to_antenna_ = -1;
  RadioCsvStats stats_;
};

template <std::size_t N>
FindingList LinkReader::findings(const std::array<std::string_view, N>& known_columns) const {
  FindingList list;
  const auto add = [&list](const char* id, Severity severity, std::string text, std::uint64_t n) {
    Finding finding;
    finding.id = id;
    finding.severity = severity;
    finding.text = std::move(text);
    finding.value = static_cast<double>(n);
    list.push_back(std::move(finding));
  };
  for (const auto& [unknown, seen] : stats_.unknown) {
    add("ranges.unknown", Severity::kWarning,
        fmt::format("{}:{}: {} is no vehicle ({}); {} of {} rows skipped", name_, seen.first_line,
                    quoted(unknown), known_names(), seen.rows, stats_.rows),
        seen.rows);
  }
  if (stats_.bad_rows > 0) {
    add("ranges.rows", Severity::kWarning,
        fmt::format("{}:{}: {}; {} of {} rows skipped", name_, stats_.first_bad_line,
                    stats_.first_bad_reason, stats_.bad_rows, stats_.rows),
        stats_.bad_rows);
  }
  if (stats_.self_rows > 0) {
    add("ranges.self", Severity::kWarning,
        fmt::format("{}: {} of {} rows link a vehicle with itself; skipped", name_,
                    stats_.self_rows, stats_.rows),
        stats_.self_rows);
  }
  std::string extra;
  for (const std::string& column : csv_.header()) {
    const bool known =
        std::find(known_columns.begin(), known_columns.end(), column) != known_columns.end();
    if (!known && extra.size() < 200) extra += (extra.empty() ? "" : ", ") + quoted(column);
  }
  if (!extra.empty()) {
    add("ranges.columns", Severity::kInfo, fmt::format("{}: columns not used: {}", name_, extra),
        1);
  }
  return list;
}

tl::unexpected<Error> nothing_fits(const LinkReader& reader, const std::string& name,
                                   const FindingList& findings) {
  std::string what = "has no row that fits";
  if (reader.stats().rows == 0) {
    what = "has no rows";
  } else if (!findings.empty()) {
    what += " (" + findings.front().text + ")";
  }
  return fail(ErrorCode::kInput, name, what,
              "The columns from and to must name vehicles: " + reader.known_names() + ".");
}

Result<RangeCsv> ranges_from(Result<CsvReader> csv, const std::string& name,
                             const RadioNames& names) {
  if (!csv) return tl::make_unexpected(csv.error());
  LinkReader reader(std::move(*csv), name, names);
  if (auto status = reader.require("range_m"); !status) return tl::make_unexpected(status.error());
  const int rssi = reader.csv().column("rssi_dbm");
  const int first_path = reader.csv().column("first_path_dbm");
  const int sigma = reader.csv().column("sigma_m");
  RangeCsv out;
  Link link;
  double range_m = 0.0;
  while (true) {
    const auto more = reader.next(link, range_m);
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) break;
    sensor::RangeSample sample;
    sample.t = link.t;
    sample.from = link.from.vehicle;
    sample.to = link.to.vehicle;
    sample.from_antenna = link.from.antenna;
    sample.to_antenna = link.to.antenna;
    sample.range_m = range_m;
    sample.rssi_dbm = reader.optional_number(rssi);
    sample.first_path_dbm = reader.optional_number(first_path);
    sample.sigma_m = std::max(0.0, reader.optional_number(sigma));
    out.samples.push_back(sample);
  }
  out.stats = reader.stats();
  out.findings = reader.findings(kRangeColumns);
  if (out.samples.empty()) return nothing_fits(reader, name, out.findings);
  return out;
}

Result<RadioCsv> radio_from(Result<CsvReader> csv, const std::string& name,
                            const RadioNames& names) {
  if (!csv) return tl::make_unexpected(csv.error());
  LinkReader reader(std::move(*csv), name, names);
  if (auto status = reader.require("rssi_dbm"); !status) return tl::make_unexpected(status.error());
  RadioCsv out;
  Link link;
  double rssi_dbm = 0.0;
  while (true) {
    const auto more = reader.next(link, rssi_dbm);
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) break;
    out.samples.push_back({link.t, link.from.vehicle, link.to.vehicle, rssi_dbm});
  }
  out.stats = reader.stats();
  out.findings = reader.findings(kRadioColumns);
  if (out.samples.empty()) return nothing_fits(reader, name, out.findings);
  return out;
}

}  // namespace

Result<RangeCsv> read_ranges_csv(const std::string& path, const RadioNames& names) {
  return ranges_from(CsvReader::open(path), path, names);
}

Result<RangeCsv> parse_ranges_csv(std::string text, const std::string& name,
                                  const RadioNames& names) {
  return ranges_from(CsvReader::from_text(std::move(text), name), name, names);
}

Result<RadioCsv> read_radio_csv(const std::string& path, const RadioNames& names) {
  return radio_from(CsvReader::open(path), path, names);
}

Result<RadioCsv> parse_radio_csv(std::string text, const std::string& name,
                                 const RadioNames& names) {
  return radio_from(CsvReader::from_text(std::move(text), name), name, names);
}

}  // namespace rali::io
