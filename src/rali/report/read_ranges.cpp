#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "rali/report/internal/cell_thinner.hpp"
#include "rali/report/internal/read_parts.hpp"
#include "rali/report/internal/table_rows.hpp"

namespace rali::report {
namespace {

/// Dots per pair and fate: what a drawing can show.
constexpr std::size_t kDotsMax = 1200;
/// A fleet has fewer; the rest is counted as strangers'.
constexpr std::size_t kPairsMax = 128;
constexpr std::size_t kNamesMax = 5, kNameBytesMax = 40;

constexpr std::array<std::string_view, kRangeFateCount> kFateNames = {
    "used",      "nlos", "outlier",    "blocked_by_gate", "out_of_limits", "no_pose",
    "duplicate", "late", "unknown_id", "not_needed",      "bad_geometry",  "other"};
constexpr std::array<std::string_view, kRangeFateCount> kFateWords = {"used",
                                                                      "no line of sight",
                                                                      "outlier",
                                                                      "stopped by the gate",
                                                                      "out of limits",
                                                                      "no pose at that time",
                                                                      "measured twice",
                                                                      "too late",
                                                                      "unknown radio",
                                                                      "not needed",
                                                                      "across the degenerate axis",
                                                                      "unknown reason"};

void note_name(const std::string& name, std::vector<std::string>& names) {
  const std::string shown = name.substr(0, kNameBytesMax);
  if (names.size() >= kNamesMax) return;
  if (std::find(names.begin(), names.end(), shown) == names.end()) names.push_back(shown);
}

/// Numbers of one pair while its rows come.
class PairTally {
 public:
  void add(const TableRow& row, double t_s, RangeFate fate) {
    const auto i = static_cast<std::size_t>(fate);
    const double residual_m = row.number("residual_m");
    const double bias_m = row.number("bias_m");
    ++count_[i];
    thinners_[i].add({t_s, residual_m});
    if (std::isfinite(bias_m)) bias_m_ = bias_m;
    if (fate != RangeFate::kUsed || !std::isfinite(residual_m)) return;
    // Welford's: exact for a mean far from zero.
    const double off_m = residual_m - mean_m_;
    mean_m_ += off_m / static_cast<double>(++n_);
    squares_m2_ += off_m * (residual_m - mean_m_);
  }

  [[nodiscard]] PairRanges result(const std::string& a, const std::string& b) const {
    PairRanges pair;
    pair.a = a;
    pair.b = b;
    pair.count = count_;
    for (std::size_t i = 0; i < kRangeFateCount; ++i) pair.dots[i] = thinners_[i].dots();
    pair.bias_m = bias_m_;
    if (n_ > 1) pair.residual_std_m = std::sqrt(squares_m2_ / static_cast<double>(n_ - 1));
    return pair;
  }

 private:
  std::array<std::size_t, kRangeFateCount> count_{};
  std::vector<CellThinner> thinners_{kRangeFateCount, CellThinner(kDotsMax)};
  double bias_m_ = kUnknown, mean_m_ = 0.0, squares_m2_ = 0.0;
  std::size_t n_ = 0;
};

class TableTally {
 public:
  TableTally(Time t_begin, RunData& run)
      : t_begin_(t_begin), run_(run), heard_(run.vehicles.size()) {}

  void add(const TableRow& row) {
    RangeTable& table = run_.range_table;
    const double t_s = row.seconds("stamp_s", t_begin_);
    const std::string reason = row.text("reason");
    const RangeFate fate = fate_of(reason, row.flag("used"));
    ++table.rows;
    ++table.count[static_cast<std::size_t>(fate)];
    if (fate == RangeFate::kOther) note_name(reason, table.other_reasons);
    std::size_t from = vehicle(row.text("from")), to = vehicle(row.text("to"));
    const bool strange = from == kNobody || to == kNobody;
    if (from > to) std::swap(from, to);
    if (strange || (pairs_.size() >= kPairsMax && !pairs_.contains({from, to}))) {
      add_stranger(row);
      return;
    }
    pairs_[{from, to}].add(row, t_s, fate);
    heard_[from].add(t_s, fate == RangeFate::kUsed);
    if (to != from) heard_[to].add(t_s, fate == RangeFate::kUsed);
  }

  void finish() {
    for (const auto& [ends, tally] : pairs_) {
      run_.range_table.pairs.push_back(
          tally.result(run_.vehicles[ends.first].name, run_.vehicles[ends.second].name));
    }
    for (std::size_t i = 0; i < heard_.size(); ++i) run_.vehicles[i].heard = heard_[i].spans();
  }

 private:
  static constexpr std::size_t kNobody = static_cast<std::size_t>(-1);

  [[nodiscard]] std::size_t vehicle(const std::string& name) const {
    for (std::size_t i = 0; i < run_.vehicles.size(); ++i) {
      if (run_.vehicles[i].name == name) return i;
    }
    return kNobody;
  }

  void add_stranger(const TableRow& row) {
    ++run_.range_table.strangers;
    for (const char* end : {"from", "to"}) {
      const std::string name = row.text(end);
      if (vehicle(name) == kNobody) note_name(name, run_.range_table.stranger_names);
    }
  }

  Time t_begin_;
  RunData& run_;
  std::map<std::pair<std::size_t, std::size_t>, PairTally> pairs_;
  std::vector<HeardBins> heard_;
};

}  // namespace

std::string_view fate_name(RangeFate fate) { return kFateNames[static_cast<std::size_t>(fate)]; }

std::string_view fate_words(RangeFate fate) { return kFateWords[static_cast<std::size_t>(fate)]; }

RangeFate fate_of(std::string_view reason, bool used) {
  if (reason.empty()) return used ? RangeFate::kUsed : RangeFate::kOther;
  const auto found = std::find(kFateNames.begin(), kFateNames.end(), reason);
  if (found == kFateNames.end()) return RangeFate::kOther;
  const auto fate = static_cast<RangeFate>(found - kFateNames.begin());
  // A row that contradicts itself was not shown to be used.
  return (fate == RangeFate::kUsed) == used ? fate : RangeFate::kOther;
}

std::size_t PairRanges::total() const {
  return std::accumulate(count.begin(), count.end(), std::size_t{0});
}

void read_ranges_table(const std::string& dir, Time t_begin, RunData& run) {
  run.range_table.known = file_exists(dir + "/ranges.csv");
  TableTally tally(t_begin, run);
  read_table(dir, "ranges.csv", run, [&](const TableRow& row) { tally.add(row); });
  tally.finish();
}

}  // namespace rali::report
