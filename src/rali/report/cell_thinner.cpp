#include "rali/report/internal/cell_thinner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rali::report {
namespace {

/// No run is longer; larger times are clamped. Keeps the cell indices small.
constexpr double kTime_s = 1e9, kResidual_m = 1e6;
/// Residuals below this are drawn nearly linearly.
constexpr double kLinear_m = 0.02;
/// Coarser cells would merge dots that are distinct in a drawing.
constexpr double kCellResidualMax = 0.4;
constexpr std::size_t kBinsMax = 2000;

double bounded(double value, double limit) { return std::clamp(value, -limit, limit); }

std::int64_t floored(double value) { return static_cast<std::int64_t>(std::floor(value)); }

}  // namespace

CellThinner::Cell CellThinner::cell_of(const RangeDot& dot) const {
  const std::int64_t t = floored(bounded(dot.t_s, kTime_s) / cell_s_);
  if (!std::isfinite(dot.residual_m)) return {t, std::numeric_limits<std::int64_t>::min()};
  const double residual = std::asinh(bounded(dot.residual_m, kResidual_m) / kLinear_m);
  return {t, floored(residual / cell_residual_)};
}

void CellThinner::keep(const RangeDot& dot) {
  const auto [at, is_new] = kept_.try_emplace(cell_of(dot), dot);
  if (!is_new && dot.t_s < at->second.t_s) at->second = dot;
}

void CellThinner::coarsen() {
  cell_s_ *= 2.0;
  cell_residual_ = std::min(2.0 * cell_residual_, kCellResidualMax);
  std::map<Cell, RangeDot> fine;
  std::swap(fine, kept_);
  for (const auto& [cell, dot] : fine) keep(dot);
}

void CellThinner::add(const RangeDot& dot) {
  if (!std::isfinite(dot.t_s)) return;
  keep(dot);
  while (kept_.size() > dots_max_ && cell_s_ < 4.0 * kTime_s) coarsen();
}

std::vector<RangeDot> CellThinner::dots() const {
  std::vector<RangeDot> out;
  for (const auto& [cell, dot] : kept_) out.push_back(dot);
  std::stable_sort(out.begin(), out.end(),
                   [](const RangeDot& a, const RangeDot& b) { return a.t_s < b.t_s; });
  return out;
}

void ReceivedBins::coarsen() {
  bin_s_ *= 2.0;
  std::map<std::int64_t, std::pair<std::size_t, std::size_t>> fine;
  std::swap(fine, bins_);
  for (const auto& [bin, counts] : fine) {
    auto& [used, rejected] = bins_[bin >= 0 ? bin / 2 : (bin - 1) / 2];
    used += counts.first;
    rejected += counts.second;
  }
}

void ReceivedBins::add(double t_s, bool used) {
  if (!std::isfinite(t_s)) return;
  auto& counts = bins_[floored(bounded(t_s, kTime_s) / bin_s_)];
  ++(used ? counts.first : counts.second);
  while (bins_.size() > kBinsMax) coarsen();
}

std::vector<Received> ReceivedBins::spans() const {
  std::vector<Received> out;
  for (const auto& [bin, counts] : bins_) {
    const double start_s = static_cast<double>(bin) * bin_s_;
    out.push_back({start_s, start_s + bin_s_, counts.first, counts.second});
  }
  return out;
}

}  // namespace rali::report
