// The part of PaperRangeStage that reports the outcome of ranges and keyframes after a scan.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "rali/fleet/facts/keyframe_number.hpp"
#include "rali/geometry/so3.hpp"
#include "rali/ranging/range_model.hpp"
#include "rali/vehicle/paper_range_stage.hpp"

namespace rali::vehicle {

using geometry::SE3;
using geometry::Vec3;
using odometry::ScanResult;
using ranging::RangeReason;
using ranging::RangeUse;
using sensor::RangeSample;

namespace {

/// Keyframes that moved less than this are not reported again (algorithms 5.5).
constexpr double kReportedM = 0.02;
constexpr double kReportedRad = 0.1 * std::numbers::pi / 180.0;

bool differ(const SE3& a, const SE3& b) {
  return (a.p - b.p).norm() > kReportedM ||
         geometry::so3_log(a.R.transpose() * b.R).norm() > kReportedRad;
}

}  // namespace

RangeEffect PaperRangeStage::after_scan(const ScanResult& result, OutputList& out) {
  if (result.state == odometry::TrackState::kWaiting) return {};
  // Ranges are compared with the pose as it was before they moved it.
  const SE3 T_end = T_uncorrected_.value_or(result.T_odom_body);
  for (auto& [key, pair] : pairs_) {
    predict(key, pair, result.t, T_end);
    calibrate(key, pair, result, T_end);
    seek(key, pair, result, T_end);
    report_ranges(pair, result.t, out);
  }
  report_keyframes(out);
  const degeneracy::PaperDegree degree = degree_of(result);
  const bool degenerate = degree.degenerate && degree.direction_known;
  degenerate_odom_ =
      degenerate ? std::optional<Vec3>(result.T_odom_body.R * degree.direction_body) : std::nullopt;
  if (!first_pose_) first_pose_ = result.T_odom_body;
  t_last_ = result.t;
  T_last_ = result.T_odom_body;
  covariance_m2_ = result.covariance.bottomRightCorner<3, 3>();
  T_uncorrected_.reset();
  const RangeEffect effect = effect_;
  effect_ = {};
  return effect;
}

SE3 PaperRangeStage::pose_at(Time t, Time t_end, const SE3& T_end) const {
  const double whole_s = seconds_between(t_last_, t_end);
  if (!first_pose_ || !(whole_s > 0.0)) return T_end;
  const double fraction = std::clamp(seconds_between(t_last_, t) / whole_s, 0.0, 1.0);
  return geometry::interpolate(T_last_, T_end, fraction);
}

void PaperRangeStage::predict(const PairKey& key, Pair& pair, Time t_end, const SE3& T_end) const {
  if (!pair.p_odom_peer_m) return;
  for (Pending& pending : pair.pending) {
    RangeUse& use = pending.use;
    if (!std::isnan(use.predicted_m)) continue;
    const Vec3 p = pose_at(use.sample.t, t_end, T_end) * own_end(key);
    use.bias_m = pair.bias_m + (pair.calibration ? pair.calibration->constant_m() : 0.0);
    use.predicted_m = (p - *pair.p_odom_peer_m).norm() + use.bias_m;
    use.residual_m = use.sample.range_m - use.predicted_m;
  }
}

/// Locates a peer of unknown position by ranges along the own path.
void PaperRangeStage::seek(const PairKey& key, Pair& pair, const ScanResult& result,
                           const SE3& T_end) {
  const double height_m = peers_end(key).z() - own_end(key).z();
  for (const RangeSample& sample : pair.sought) {
    ranging::FinderSample s;
    s.t = sample.t;
    s.p_odom_antenna_m = pose_at(sample.t, result.t, T_end) * own_end(key);
    s.covariance_m2 = result.covariance.bottomRightCorner<3, 3>();
    s.passage_odom = passage_odom_;
    s.range_m = sample.range_m;
    s.sigma_m = ranging::sigma_of(sample.range_m, settings_.ranging.limits, sample.sigma_m);
    const auto found = pair.finder.add(s, height_m, Vec3::UnitZ());
    if (!found) continue;
    pair.p_odom_peer_m = found->p_odom_m;
    pair.finder.reset();
    break;
  }
  pair.sought.clear();
}

void PaperRangeStage::report_ranges(Pair& pair, Time now, OutputList& out) const {
  std::erase_if(pair.pending, [&](const Pending& pending) {
    const double age_s = seconds_between(pending.use.sample.t, now);
    // Older ones are no longer part of any fit.
    const bool report = pending.decided || age_s > paper_.smoother_s;
    if (report) out.emplace_back(pending.use);
    return report;
  });
}

void PaperRangeStage::report_keyframes(OutputList& out) {
  const auto& nodes = window_.nodes();
  for (const PaperWindow::Node& node : nodes) {
    SE3& reported = reported_[node.seq];
    if (!differ(reported, node.T_odom_body)) continue;
    reported = node.T_odom_body;
    const KeyframeId id{self_, fleet::first_keyframe_of(settings_.facts.epoch) + node.seq};
    out.emplace_back(KeyframeCorrected{id, node.t, node.T_odom_body, node.covariance});
  }
  if (!nodes.empty()) reported_.erase(reported_.begin(), reported_.lower_bound(nodes.front().seq));
}

void PaperRangeStage::flush(OutputList& out) {
  for (auto& [key, pair] : pairs_) {
    for (const Pending& pending : pair.pending) out.emplace_back(pending.use);
    pair.pending.clear();
  }
  for (const RangeSample& sample : waiting_) {
    RangeUse use;
    use.sample = sample;
    out.emplace_back(use);
  }
  waiting_.clear();
  std::uint64_t all = 0;
  for (const std::uint64_t n : outcomes_) all += n;
  if (all > 0) out.emplace_back(summary());
}

Finding PaperRangeStage::summary() const {
  Finding f;
  f.id = "ranging.paper_corrections";
  f.severity = Severity::kInfo;
  f.t = t_last_;
  f.vehicle = settings_.name;
  std::uint64_t all = 0;
  std::string text;
  for (std::size_t i = 0; i < outcomes_.size(); ++i) {
    all += outcomes_[i];
    if (outcomes_[i] == 0) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", ranging::kCorrectionOutcomeNames[i],
                        outcomes_[i]);
  }
  f.value = static_cast<double>(outcomes_.front());
  f.limit = static_cast<double>(all);
  f.text = fmt::format("keyframes compared with a smoothed range: {}; longest shift {:.2f} m", text,
                       longest_m_);
  if (closest_ > 0) {
    f.text += fmt::format(", {} where the circle missed the line", closest_);
  }
  return f;
}

}  // namespace rali::vehicle
