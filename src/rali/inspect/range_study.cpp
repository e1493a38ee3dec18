#include "rali/inspect/range_study.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/base/counted.hpp"
#include "rali/inspect/make_finding.hpp"
#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/text.hpp"

namespace rali::inspect {
namespace {

constexpr double kLongest_m = 1000.0;
constexpr std::size_t kFrozenMin = 20;
constexpr double kTogether_s = 1.0;  ///< at 1 m/s2 a range between two is interpolated to 0.13 m
constexpr double kDirections_m = 0.15;

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// "v1" for the antenna "v1/rear".
std::string vehicle_of(const std::string& name) { return name.substr(0, name.find('/')); }

using Samples = std::vector<std::pair<Time, double>>;

/// Ranges less those of the other direction at the same time, between its ranges before and after:
/// a moving pair changes its distance from one to the next.
std::vector<double> differences(const Samples& samples, const Samples& others) {
  std::vector<double> out_m;
  std::size_t k = 0;
  for (const auto& [t, range_m] : samples) {
    while (k + 1 < others.size() && others[k + 1].first <= t) ++k;
    if (k + 1 >= others.size() || others[k].first > t) continue;
    const double gap_s = seconds_between(others[k].first, others[k + 1].first);
    if (gap_s > kTogether_s) continue;
    const double fraction = seconds_between(others[k].first, t) / gap_s;
    const double other_m = (1.0 - fraction) * others[k].second + fraction * others[k + 1].second;
    out_m.push_back(range_m - other_m);
  }
  return out_m;
}

}  // namespace

void RangeStudy::add(Time t, const std::string& from, const std::string& to, double range_m) {
  const auto key = std::pair{from, to};
  if (pairs_.size() >= kPairsMax && !pairs_.contains(key)) {
    ++pairs_refused_;
    return;
  }
  Series& series = pairs_[key];
  ++series.count;
  if (range_m == 0.0) {
    ++zeros_;
  } else if (!(range_m > 0.0) || range_m > kLongest_m) {
    ++series.invalid;
  } else if (series.samples.size() < kSamplesMax) {
    series.samples.emplace_back(t, range_m);
  }
}

void RangeStudy::add_radio(const std::string& topic, const std::string& vehicle,
                           std::optional<std::int64_t> number, bool has_stamp) {
  TopicRadios& radios = topics_of_radios_[topic];
  if (number) radios.own.emplace(*number, vehicle);
  ++(has_stamp ? radios.with_stamp : radios.without_stamp);
}

std::vector<std::pair<Time, double>> RangeStudy::between(const std::string& a,
                                                         const std::string& b) const {
  const auto owner = [&](const std::string& name) {
    for (const auto& [topic, radios] : topics_of_radios_) {
      for (const auto& [number, vehicle] : radios.own) {
        if (name == fmt::format("{}", number)) return vehicle;
      }
    }
    return vehicle_of(name);
  };
  std::vector<std::pair<Time, double>> samples;
  for (const auto& [pair, series] : pairs_) {
    const std::string from = owner(pair.first), to = owner(pair.second);
    if (!((from == a && to == b) || (from == b && to == a))) continue;
    samples.insert(samples.end(), series.samples.begin(), series.samples.end());
  }
  std::stable_sort(samples.begin(), samples.end(),
                   [](const auto& x, const auto& y) { return x.first < y.first; });
  return samples;
}

std::vector<std::string> RangeStudy::names() const {
  std::set<std::string> names;
  for (const auto& [pair, series] : pairs_) {
    names.insert(pair.first);
    names.insert(pair.second);
  }
  return {names.begin(), names.end()};
}

void RangeStudy::report(const std::string& topic, FindingList& out) const {
  const Pairs pairs = sorted_pairs();
  for (const auto& [pair, series] : pairs) {
    report_pair(pair.first + "->" + pair.second, series, topic, out);
  }
  report_directions(pairs, topic, out);
  if (zeros_ > 0) {
    out.push_back(
        make_finding("D14", Severity::kInfo, topic,
                     {fmt::format("{} distances are 0: taken as \"none\"", zeros_), "", ""},
                     {static_cast<double>(zeros_), 0.0}));
  }
  if (pairs_refused_ > 0) {
    out.push_back(make_finding("D14", Severity::kError, topic,
                               {fmt::format("more than {} pairs of names", kPairsMax),
                                "the columns from and to do not hold names", "Check the file."},
                               {static_cast<double>(pairs_refused_), 0.0}));
  }
}

RangeStudy::Pairs RangeStudy::sorted_pairs() const {
  Pairs pairs = pairs_;
  for (auto& [pair, series] : pairs) {
    std::stable_sort(series.samples.begin(), series.samples.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
  }
  return pairs;
}

void RangeStudy::report_strangers(const std::vector<std::string>& vehicles,
                                  FindingList& out) const {
  if (vehicles.empty()) return;
  for (const std::string& name : names()) {
    if (std::find(vehicles.begin(), vehicles.end(), vehicle_of(name)) != vehicles.end()) continue;
    std::uint64_t rows = 0;
    for (const auto& [pair, series] : pairs_) {
      if (pair.first == name || pair.second == name) rows += series.count;
    }
    out.push_back(make_finding(
        "D14", Severity::kWarning, "",
        {fmt::format("'{}' is no vehicle ({}); {} with it", name, fmt::join(vehicles, ", "),
                     counted(rows, "range")),
         "they are left out", "Name the vehicle in fleet.yaml, or its radio in ranges.sources."},
        {static_cast<double>(rows), 0.0}));
  }
}

void RangeStudy::report_pair(const std::string& name, const Series& series,
                             const std::string& topic, FindingList& out) const {
  std::vector<double> steps_s;
  std::size_t run = 1, frozen = 1;
  double longest_s = 0.0;
  for (std::size_t i = 1; i < series.samples.size(); ++i) {
    const double step = seconds_between(series.samples[i - 1].first, series.samples[i].first);
    if (step > 0.0) steps_s.push_back(step);
    longest_s = std::max(longest_s, step);
    run = series.samples[i].second == series.samples[i - 1].second ? run + 1 : 1;
    frozen = std::max(frozen, run);
  }
  const double period_s = median(steps_s);
  const bool gap = longest_s > std::max(2.0, 10.0 * period_s);
  out.push_back(make_finding(
      "D14", gap ? Severity::kWarning : Severity::kInfo, topic,
      {fmt::format("{}: {}, {:.1f} Hz, longest gap {:.1f} s", name, counted(series.count, "range"),
                   period_s > 0.0 ? 1.0 / period_s : 0.0, longest_s),
       gap ? "nothing holds the vehicles together meanwhile" : "", ""},
      {longest_s, 2.0}));
  if (frozen >= kFrozenMin) {
    out.push_back(make_finding("D14", Severity::kWarning, topic,
                               {fmt::format("{}: the same value {} times in a row", name, frozen),
                                "harmless at rest; while driving, the radio repeats its last value",
                                "Update the radio's firmware, or leave out what it repeats."},
                               {static_cast<double>(frozen), static_cast<double>(kFrozenMin)}));
  }
  if (series.invalid == 0) return;
  out.push_back(
      make_finding("D14", Severity::kWarning, topic,
                   {fmt::format("{}: {} ranges are negative, not a number or above {:.0f} m", name,
                                series.invalid, kLongest_m),
                    "they are left out", "Check the unit: metres."},
                   {static_cast<double>(series.invalid), 0.0}));
}

void RangeStudy::report_directions(const Pairs& pairs, const std::string& topic, FindingList& out) {
  for (const auto& [pair, forth] : pairs) {
    if (pair.first >= pair.second) continue;
    const auto back = pairs.find({pair.second, pair.first});
    if (back == pairs.end()) continue;
    const std::vector<double> differences_m = differences(forth.samples, back->second.samples);
    if (differences_m.size() < 10) continue;
    const double difference_m = median(differences_m);
    const bool apart = std::abs(difference_m) > kDirections_m;
    out.push_back(
        make_finding("D15", apart ? Severity::kWarning : Severity::kInfo, topic,
                     {fmt::format("{}->{} is {:+.2f} m against {}->{}", pair.first, pair.second,
                                  difference_m, pair.second, pair.first),
                      apart ? "at least one direction has a bias" : "",
                      apart ? "Calibrate the antenna delays, or let the bias be estimated." : ""},
                     {difference_m, kDirections_m}));
  }
}

void RangeStudy::report_silent(const std::vector<std::string>& vehicles, FindingList& out) const {
  constexpr std::size_t kVehiclesMax = 20;  // a longer list of pairs is of no use
  std::set<std::pair<std::string, std::string>> measured;
  std::set<std::string> named;
  for (const auto& [pair, series] : pairs_) {
    const std::string a = vehicle_of(pair.first), b = vehicle_of(pair.second);
    measured.insert({std::min(a, b), std::max(a, b)});
    named.insert({a, b});
  }
  std::set<std::string> all = named;
  all.insert(vehicles.begin(), vehicles.end());
  if (all.size() > kVehiclesMax) return;
  for (auto a = all.begin(); a != all.end(); ++a) {
    if (!named.contains(*a)) {
      out.push_back(make_finding("D14", Severity::kWarning, "",
                                 {*a + " measured no range, and none was measured to it",
                                  "only start poses and scans can join it to the others",
                                  "Check that its radio ran, and name it in ranges.sources."}));
    }
    for (auto b = std::next(a); b != all.end(); ++b) {
      if (measured.contains({*a, *b})) continue;
      out.push_back(
          make_finding("D14", Severity::kInfo, "",
                       {fmt::format("{} and {} never measured each other", *a, *b), "", ""}));
    }
  }
}

Status read_ranges_csv(const std::string& path, RangeStudy& study, FindingList& findings) {
  auto csv = io::CsvReader::open(path);
  if (!csv) return tl::make_unexpected(csv.error());
  int columns[4] = {};
  constexpr const char* kNames[4] = {"stamp_s", "from", "to", "range_m"};
  for (int i = 0; i < 4; ++i) {
    const auto column = csv->require(kNames[i]);
    if (!column) return tl::make_unexpected(column.error());
    columns[i] = *column;
  }
  std::uint64_t rows = 0, bad = 0;
  std::string first_bad;
  while (true) {
    const auto row = csv->next();
    if (!row) return tl::make_unexpected(row.error());
    if (!*row) break;
    ++rows;
    const auto stamp = io::parse_stamp(csv->cell(columns[0]));
    const auto range_m = io::parse_number(csv->cell(columns[3]));
    if (!stamp || !range_m) {
      if (bad++ == 0) first_bad = csv->where();
      continue;
    }
    study.add(*stamp, std::string(csv->cell(columns[1])), std::string(csv->cell(columns[2])),
              *range_m);
  }
  if (bad == rows) {
    return fail(ErrorCode::kInput, rows == 0 ? path : first_bad,
                rows == 0 ? "has no rows" : "no row has numbers in stamp_s and range_m",
                "Times are seconds, ranges are metres.");
  }
  if (bad == 0) return {};
  findings.push_back(
      make_finding("D14", Severity::kWarning, path,
                   {fmt::format("{}: stamp_s or range_m is not a number; {} of {} like this",
                                first_bad, bad, counted(rows, "row")),
                    "they are left out", "Times are seconds, ranges are metres."},
                   {static_cast<double>(bad), 0.0}));
  return {};
}

}  // namespace rali::inspect
