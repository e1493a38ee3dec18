#include "rali/drive/closed_loop/step_times.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <variant>

#include <fmt/format.h>

namespace rali::drive {
namespace {

constexpr double kFirst_s = 1e-6, kGrowth = 1.1;

struct Name {
  std::string_view operator()(const fleet::OwnFact&) const { return "fact"; }

  std::string_view operator()(const fleet::OwnPose&) const { return "pose"; }

  std::string_view operator()(const fleet::ReceivedRange&) const { return "range"; }

  std::string_view operator()(const fleet::ReceivedRadio&) const { return "radio"; }

  std::string_view operator()(const fleet::DriveStatus&) const { return "drive"; }

  std::string_view operator()(const fleet::Envelope&) const { return "message"; }

  std::string_view operator()(const fleet::NodeTick&) const { return "tick"; }

  std::string_view operator()(const fleet::Persisted&) const { return "persisted"; }

  std::string_view operator()(const fleet::PersistFailed&) const { return "persist_failed"; }

  std::string_view operator()(const fleet::ConfirmRole&) const { return "confirm_role"; }

  std::string_view operator()(const fleet::OperatorOrder&) const { return "order"; }

  std::string_view operator()(const fleet::JobDone&) const { return "job"; }
};

}  // namespace

void TimeHistogram::add(double s) {
  const double bin = std::log(std::max(s, kFirst_s) / kFirst_s) / std::log(kGrowth);
  ++bins_[std::min(kBins - 1, static_cast<std::size_t>(bin))];
  ++count_;
  max_s_ = std::max(max_s_, s);
}

double TimeHistogram::quantile_s(double fraction) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(fraction * static_cast<double>(count_)));
  std::uint64_t sum = 0;
  for (std::size_t k = 0; k < kBins && count_ > 0; ++k) {
    sum += bins_[k];
    if (sum >= wanted) return std::min(max_s_, kFirst_s * std::pow(kGrowth, k + 1));
  }
  return max_s_;
}

double StepTimes::thread_s() {
  timespec t{};
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t) != 0) return 0.0;
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void StepTimes::add(const fleet::NodeEvent& event, double s) {
  kinds_[std::visit(Name{}, event)].add(s);
}

std::vector<StepTimes::Row> StepTimes::rows() const {
  std::vector<Row> rows;
  for (const auto& [name, times] : kinds_) rows.push_back({name, &times});
  return rows;
}

std::vector<std::string> StepTimes::lines() const {
  std::vector<std::string> lines;
  for (const Row& row : rows()) {
    lines.push_back(fmt::format("{}: {} steps, p50 {:.3f} ms, p99.9 {:.2f} ms, max {:.2f} ms",
                                row.event, row.times->count(), 1e3 * row.times->quantile_s(0.5),
                                1e3 * row.times->quantile_s(0.999), 1e3 * row.times->max_s()));
  }
  return lines;
}

}  // namespace rali::drive
