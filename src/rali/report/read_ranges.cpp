#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "rali/report/internal/cell_thinner.hpp"
#include "rali/report/internal/read_parts.hpp"
#include "rali/report/internal/table_rows.hpp"

namespace rali::report {
namespace {

/// Dots per pair and outcome: the limit of what a drawing can show.
constexpr std::size_t kDotsMax = 1200;
/// No fleet has more; the rest is counted as ranges of strangers.
constexpr std::size_t kPairsMax = 128;
constexpr std::size_t kNamesMax = 5, kNameBytesMax = 40;

constexpr std::array<std::string_view, kRangeOutcomeCount> kOutcomeNames = {
    "used",      "nlos", "outlier",    "blocked_by_gate", "out_of_limits", "no_pose",
    "duplicate", "late", "unknown_id", "not_needed",      "bad_geometry",  "other"};
constexpr std::array<std::string_view, kRangeOutcomeCount> kOutcomeWords = {
    "used",
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

/// Running statistics of one pair while its rows are read.
class PairTally {
 public:
  void add(const TableRow& row, double t_s, RangeOutcome outcome) {
    const auto i = static_cast<std::size_t>(outcome);
    const double residual_m = row.number("residual_m");
    const double bias_m = row.number("bias_m");
    ++count_[i];
    thinners_[i].add({t_s, residual_m});
    if (std::isfinite(bias_m)) bias_m_ = bias_m;
    if (outcome != RangeOutcome::kUsed || !std::isfinite(residual_m)) return;
    // Welford's algorithm: accurate for a mean far from zero.
    const double off_m = residual_m - mean_m_;
    mean_m_ += off_m / static_cast<double>(++n_);
    squares_m2_ += off_m * (residual_m - mean_m_);
  }

  [[nodiscard]] PairRanges result(const std::string& a, const std::string& b) const {
    PairRanges pair;
    pair.a = a;
    pair.b = b;
    pair.count = count_;
    for (std::size_t i = 0; i < kRangeOutcomeCount; ++i) pair.dots[i] = thinners_[i].dots();
    pair.bias_m = bias_m_;
    if (n_ > 1) pair.residual_std_m = std::sqrt(squares_m2_ / static_cast<double>(n_ - 1));
    return pair;
  }

 private:
  std::array<std::size_t, kRangeOutcomeCount> count_{};
  std::vector<CellThinner> thinners_{kRangeOutcomeCount, CellThinner(kDotsMax)};
  double bias_m_ = kUnknown, mean_m_ = 0.0, squares_m2_ = 0.0;
  std::size_t n_ = 0;
};

class TableTally {
 public:
  TableTally(Time t_start, RunData& run)
      : t_start_(t_start), run_(run), received_(run.vehicles.size()) {}

  void add(const TableRow& row) {
    RangeTable& table = run_.range_table;
    const double t_s = row.seconds("stamp_s", t_start_);
    const std::string reason = row.text("reason");
    const RangeOutcome outcome = outcome_of(reason, row.flag("used"));
    ++table.rows;
    ++table.count[static_cast<std::size_t>(outcome)];
    if (outcome == RangeOutcome::kOther) note_name(reason, table.other_reasons);
    std::size_t from = vehicle(row.text("from")), to = vehicle(row.text("to"));
    const bool strange = from == kNobody || to == kNobody;
    if (from > to) std::swap(from, to);
    if (strange || (pairs_.size() >= kPairsMax && !pairs_.contains({from, to}))) {
      add_stranger(row);
      return;
    }
    pairs_[{from, to}].add(row, t_s, outcome);
    received_[from].add(t_s, outcome == RangeOutcome::kUsed);
    if (to != from) received_[to].add(t_s, outcome == RangeOutcome::kUsed);
  }

  void finish() {
    for (const auto& [ends, tally] : pairs_) {
      run_.range_table.pairs.push_back(
          tally.result(run_.vehicles[ends.first].name, run_.vehicles[ends.second].name));
    }
    for (std::size_t i = 0; i < received_.size(); ++i)
      run_.vehicles[i].received = received_[i].spans();
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

  Time t_start_;
  RunData& run_;
  std::map<std::pair<std::size_t, std::size_t>, PairTally> pairs_;
  std::vector<ReceivedBins> received_;
};

}  // namespace

std::string_view outcome_words(RangeOutcome outcome) {
  return kOutcomeWords[static_cast<std::size_t>(outcome)];
}

RangeOutcome outcome_of(std::string_view reason, bool used) {
  if (reason.empty()) return used ? RangeOutcome::kUsed : RangeOutcome::kOther;
  const auto found = std::find(kOutcomeNames.begin(), kOutcomeNames.end(), reason);
  if (found == kOutcomeNames.end()) return RangeOutcome::kOther;
  const auto outcome = static_cast<RangeOutcome>(found - kOutcomeNames.begin());
  // A contradictory row does not count as used.
  return (outcome == RangeOutcome::kUsed) == used ? outcome : RangeOutcome::kOther;
}

std::size_t PairRanges::total() const {
  return std::accumulate(count.begin(), count.end(), std::size_t{0});
}

void read_ranges_table(const std::string& dir, Time t_start, RunData& run) {
  run.range_table.known = file_exists(dir + "/ranges.csv");
  TableTally tally(t_start, run);
  read_table(dir, "ranges.csv", run, [&](const TableRow& row) { tally.add(row); });
  tally.finish();
}

}  // namespace rali::report
