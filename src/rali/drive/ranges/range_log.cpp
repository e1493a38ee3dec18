#include "rali/drive/ranges/range_log.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "rali/drive/ranges/range_options.hpp"
#include "rali/io/files/csv_writer.hpp"

namespace rali::drive {
namespace {

using ranging::RangeReason;
using ranging::RangeUse;

bool same(const sensor::RangeSample& a, const sensor::RangeSample& b) {
  return a.t == b.t && a.from == b.from && a.to == b.to && a.from_antenna == b.from_antenna &&
         a.to_antenna == b.to_antenna && a.range_m == b.range_m;
}

/// Mean and spread without keeping the numbers (Welford).
struct Spread {
  std::size_t n = 0;
  double mean = 0.0, squares = 0.0;

  void add(double x) {
    ++n;
    const double off = x - mean;
    mean += off / static_cast<double>(n);
    squares += off * (x - mean);
  }
};

io::CsvRow row_of(const RangeUse& use, const std::string& from, const std::string& to) {
  io::CsvRow row;
  row.stamp(use.sample.t).text(from).text(to).fixed(use.sample.range_m, 4);
  row.fixed(use.predicted_m, 4).fixed(use.residual_m, 4).fixed(use.sigma_m, 4);
  row.fixed(use.bias_m, 4).fixed(use.p_los, 3).integer(use.used() ? 1 : 0);
  row.text(ranging::kRangeReasonNames[static_cast<std::size_t>(use.reason)]);
  return row;
}

}  // namespace

RangeReason RangeTally::commonest_refusal() const {
  const auto maximum = std::max_element(by_reason.begin() + 1, by_reason.end());
  return *maximum == 0 ? RangeReason::kUsed : static_cast<RangeReason>(maximum - by_reason.begin());
}

void RangeLog::add_handed(const sensor::RangeSample& sample) {
  Row row;
  row.use.sample = sample;
  handed_.push_back(row);
}

void RangeLog::add_refused(const sensor::RangeSample& sample, RangeReason reason) {
  RangeUse use;
  use.sample = sample;
  use.reason = reason;
  refused_.push_back(use);
}

void RangeLog::answer(const RangeUse& use, VehicleId by, bool moving) {
  const std::size_t end = by == use.sample.from ? 0 : 1;
  auto row = std::lower_bound(handed_.begin(), handed_.end(), use.sample.t,
                              [](const Row& r, Time t) { return r.use.sample.t < t; });
  // A repeat follows the first sample: each report goes to the next one without a report.
  while (row != handed_.end() && row->use.sample.t == use.sample.t &&
         (row->answered[end] || !same(row->use.sample, use.sample))) {
    ++row;
  }
  if (row == handed_.end() || row->use.sample.t != use.sample.t) return;
  row->answered[end] = true;
  const Worth worth = use.used() ? Worth::kUsed : moving ? Worth::kMoving : Worth::kStanding;
  if (worth <= row->worth) return;
  row->worth = worth;
  row->use = use;
}

std::string RangeLog::name_of(VehicleId id) const {
  if (id.value < vehicles_.size()) return vehicles_[id.value];
  const auto named = strangers_.find(id.value);
  if (named != strangers_.end()) return named->second;
  const bool numbered = id.value >= kUnknownRadios && id.value < kUnknownNames;
  return numbered ? fmt::format("{}", id.value - kUnknownRadios) : std::string();
}

std::vector<const RangeUse*> RangeLog::in_order() const {
  std::vector<const RangeUse*> rows;
  rows.reserve(handed_.size() + refused_.size());
  for (const Row& row : handed_) rows.push_back(&row.use);
  for (const RangeUse& use : refused_) rows.push_back(&use);
  std::stable_sort(rows.begin(), rows.end(),
                   [](const RangeUse* a, const RangeUse* b) { return a->sample.t < b->sample.t; });
  return rows;
}

Status RangeLog::write(const std::string& path) const {
  Result<io::CsvWriter> csv =
      io::CsvWriter::create(path, {"stamp_s", "from", "to", "range_m", "predicted_m", "residual_m",
                                   "sigma_m", "bias_m", "p_los", "used", "reason"});
  if (!csv) return tl::make_unexpected(csv.error());
  for (const RangeUse* use : in_order()) {
    const io::CsvRow row = row_of(*use, name_of(use->sample.from), name_of(use->sample.to));
    if (Status s = csv->add(row); !s) return s;
  }
  return csv->finish();
}

RangeTally RangeLog::tally() const {
  RangeTally tally;
  std::map<std::pair<VehicleId, VehicleId>, std::pair<RangePair, Spread>> pairs;
  for (const RangeUse* use : in_order()) {
    if (tally.total == 0) tally.first = use->sample.t;
    tally.last = use->sample.t;
    ++tally.total;
    ++tally.by_reason[static_cast<std::size_t>(use->reason)];
    const auto [low, high] = std::minmax(use->sample.from, use->sample.to);
    if (high.value >= vehicles_.size()) continue;
    auto& [pair, spread] = pairs[{low, high}];
    ++pair.total;
    if (std::isfinite(use->bias_m)) pair.bias_m = use->bias_m;
    if (!use->used()) continue;
    ++pair.used;
    if (std::isfinite(use->residual_m)) spread.add(use->residual_m);
  }
  for (auto& [ends, found] : pairs) {
    auto& [pair, spread] = found;
    pair.name = fmt::format("{}-{}", name_of(ends.first), name_of(ends.second));
    if (spread.n > 1) {
      pair.residual_std_m = std::sqrt(spread.squares / static_cast<double>(spread.n - 1));
    }
    tally.pairs.push_back(std::move(pair));
  }
  return tally;
}

}  // namespace rali::drive
