#include "score.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>

#include <fmt/os.h>

#include "cloud.hpp"
#include "errors.hpp"
#include "rali/eval/consistency.hpp"
#include "rali/eval/errors.hpp"

namespace rali::tunnel {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kSettle_s = 1.0;   // the NEES uses the frame of the pose after this time
constexpr double kSilence_s = 2.0;  // after which ranges have ended
constexpr double kBad_m = 0.3;      // a range with a larger error should be refused
constexpr double kBack_m = 0.2;     // a pose with a smaller error has recovered
constexpr double kBeforeLoss_s = 5.0;
constexpr double kAfterLoss_s = 20.0;
constexpr double kStay_s = 1.0;
constexpr double kMinVariance_m2 = 1e-8;  // at standstill the variance is zero

double largest(const std::vector<double>& values) {
  double maximum = 0.0;
  for (const double v : values) maximum = std::max(maximum, std::abs(v));
  return maximum;
}

double rmse(const std::vector<double>& values) { return eval::statistics(values).rmse; }

/// Pairs a second apart, starting at one index.
std::vector<std::size_t> each_second(const eval::PairList& pairs, std::size_t from) {
  std::vector<std::size_t> out;
  for (std::size_t i = from + 1; i < pairs.size(); ++i) {
    const Time last = out.empty() ? pairs[from].t : pairs[out.back()].t;
    if (seconds_between(last, pairs[i].t) >= 1.0 - 1e-3) out.push_back(i);
  }
  return out;
}

void score_consistency(const Judged& judged, PathScores& s) {
  const std::size_t anchor = pair_after(judged.pairs, kSettle_s);
  const SE3 T_est_ref = judged.pairs[anchor].est * judged.pairs[anchor].ref.inverse();
  const AxisErrors errors = axis_errors(judged, T_est_ref.inverse());
  const std::vector<double> sigma_m = axial_sigmas(judged, anchor);
  eval::PairList seconds;
  std::vector<double> axial;
  for (const std::size_t i : each_second(judged.pairs, anchor)) {
    seconds.push_back(judged.pairs[i]);
    axial.push_back(errors.axial[i] * errors.axial[i] /
                    (sigma_m[i] * sigma_m[i] + kMinVariance_m2));
  }
  if (seconds.empty()) return;
  s.nees_axial = eval::statistics(axial).mean;
  s.nees6 = eval::consistency(seconds, judged.covariances, T_est_ref, 6).mean;
}

PathScores score_path(const Judged& judged) {
  PathScores s;
  const SE3 T = best_alignment(judged);
  const AxisErrors best = axis_errors(judged, T);
  s.axial_rmse_m = rmse(best.axial);
  s.axial_max_m = largest(best.axial);
  s.lateral_rmse_m = rmse(best.lateral);
  s.vertical_rmse_m = rmse(best.vertical);
  const eval::Statistics ape = eval::translation_statistics(eval::absolute_errors(judged.pairs, T));
  s.ape_rmse_m = ape.rmse;
  s.ape_max_m = ape.max;
  const AxisErrors start = axis_errors(judged, start_alignment(judged));
  s.start_rmse_m = rmse(start.axial);
  s.start_max_m = largest(start.axial);
  score_consistency(judged, s);
  return s;
}

/// Time of the last range before the first outage; the end of the data if there is none.
Time end_of_ranges(const std::vector<Time>& received, Time t_last) {
  for (std::size_t i = 1; i < received.size(); ++i) {
    if (seconds_between(received[i - 1], received[i]) > kSilence_s) return received[i - 1];
  }
  return received.empty() ? t_last : std::min(received.back(), t_last);
}

void score_ranges(const Track& track, Time t_start, Time t_end, Scores& s) {
  std::set<std::int64_t> seconds;
  for (const Time t : track.received) {
    if (t <= t_end) seconds.insert(t.ns / 1'000'000'000);
  }
  s.received = std::min(1.0, static_cast<double>(seconds.size()) / seconds_between(t_start, t_end));
  double bad = 0.0, bad_refused = 0.0, good = 0.0, good_kept = 0.0;
  std::vector<double> nis;
  for (const RangeRow& r : track.ranges) {
    if (r.use.sample.t > t_end || r.use.reason == ranging::RangeReason::kNoPose) continue;
    const bool wrong = std::abs(r.error_m) > kBad_m;
    (wrong ? bad : good) += 1.0;
    if (wrong && !r.use.used()) bad_refused += 1.0;
    if (!wrong && r.use.used()) good_kept += 1.0;
    const double d = r.use.residual_m / r.use.sigma_m;
    if (r.use.used() && std::isfinite(d)) nis.push_back(d * d);
  }
  if (bad + good > 0.0) {
    s.bad = bad / (bad + good);
    s.used = (bad - bad_refused + good_kept) / (bad + good);
  }
  if (bad > 0.0) s.bad_refused = bad_refused / bad;
  if (good > 0.0) s.good_kept = good_kept / good;
  if (!nis.empty()) s.nis = eval::statistics(nis).mean;
}

/// The best alignment of the poses before the loss and after the recovery.
SE3 alignment_without_loss(const Judged& judged, const Track& track) {
  Judged rest;
  for (std::size_t i = 0; i < judged.pairs.size(); ++i) {
    const Time t = judged.pairs[i].t;
    const bool back = seconds_between(track.loss_end, t) > kAfterLoss_s;
    if (t < track.loss_start || back) rest.pairs.push_back(judged.pairs[i]);
  }
  return rest.pairs.empty() ? best_alignment(judged) : best_alignment(rest);
}

/// Time from the end of the loss until the error is small and stays so for a second; infinite if
/// that never happens.
double back_after_s(const Judged& judged, const AxisErrors& errors, Time loss_end) {
  std::optional<Time> since;
  for (std::size_t i = 0; i < judged.pairs.size(); ++i) {
    const Time t = judged.pairs[i].t;
    if (t < loss_end) continue;
    if (std::abs(errors.axial[i]) >= kBack_m) {
      since.reset();
    } else if (!since) {
      since = t;
    } else if (seconds_between(*since, t) >= kStay_s) {
      return seconds_between(loss_end, *since);
    }
  }
  return std::numeric_limits<double>::infinity();
}

/// Growth of the axial error during the loss relative to just before, and the time until it is
/// small again.
void score_loss(const Judged& judged, const Track& track, Scores& s) {
  const AxisErrors errors = axis_errors(judged, alignment_without_loss(judged, track));
  std::vector<double> before;
  double max_m = 0.0;
  for (std::size_t i = 0; i < judged.pairs.size(); ++i) {
    const double error_m = std::abs(errors.axial[i]);
    const Time t = judged.pairs[i].t;
    const double until_s = seconds_between(t, track.loss_start);
    if (until_s > 0.0 && until_s < kBeforeLoss_s) before.push_back(error_m);
    if (t >= track.loss_start && t < track.loss_end) max_m = std::max(max_m, error_m);
  }
  s.loss_growth_m = std::max(0.0, max_m - eval::statistics(before).mean);
  s.loss_back_s = back_after_s(judged, errors, track.loss_end);
}

void score_scans(const Track& track, const Judged& judged, Scores& s) {
  std::vector<double> degenerate;
  for (const eval::PosePair& pair : judged.pairs) {
    degenerate.push_back(track.live[pair.est_index].degenerate ? 1.0 : 0.0);
  }
  s.degenerate = eval::statistics(degenerate).mean;
  s.cpu_ms = eval::statistics(track.cpu_ms).mean;
  s.cpu_p99_ms = eval::quantile(track.cpu_ms, 0.99);
  const AxisErrors best = axis_errors(judged, best_alignment(judged));
  std::size_t worst = 0;
  for (std::size_t i = 0; i < best.axial.size(); ++i) {
    if (std::abs(best.axial[i]) > std::abs(best.axial[worst])) worst = i;
  }
  s.t_worst_s = seconds_between(track.t_start, judged.pairs[worst].t);
}

}  // namespace

Result<Scores> score(const Track& track, const Recording& recording, const Row& row) {
  if (track.live.empty() || track.truth.empty()) {
    return fail(ErrorCode::kNoAnswer, row.label, "the vehicle gave no pose");
  }
  const Time t_last = track.truth.back().t;
  const Time t_end = row.on.until_received ? end_of_ranges(track.received, t_last) : t_last;
  const auto live = judge(track.live, track.truth, t_end);
  if (!live) return tl::make_unexpected(live.error());
  const auto smoothed = judge(track.smoothed, track.truth, t_end);
  if (!smoothed) return tl::make_unexpected(smoothed.error());
  Scores s;
  s.row = row.label;
  s.scene = sim::kSceneNames[static_cast<std::size_t>(row.on.scene)];
  s.seed = recording.place().seed;
  s.ranges = row.ranges;
  s.path_m = track.path_m;
  s.judged_s = seconds_between(live->pairs.front().t, live->pairs.back().t);
  s.live = score_path(*live);
  s.smoothed = score_path(*smoothed);
  if (row.ranges) score_ranges(track, live->pairs.front().t, t_end, s);
  if (row.on.loss_s > 0.0) score_loss(*live, track, s);
  score_scans(track, *live, s);
  s.poses = live->pairs.size();
  s.scans = track.truth.size();
  s.diverged = track.diverged;
  s.findings = track.findings.size();
  if (row.mesh) {
    const auto cloud = compare_cloud(track, recording.setup().world.mesh);
    if (!cloud) return tl::make_unexpected(cloud.error());
    s.cloud_mean_m = cloud->within.mean;
    s.cloud_sd_m = cloud->within.std;
    s.cloud_beyond = cloud->fraction_beyond;
  }
  return s;
}

void dump(const std::string& dir, const Track& track, const Row& row, std::uint64_t seed) {
  std::error_code ignored;
  std::filesystem::create_directories(dir, ignored);
  std::string stem = fmt::format("{}/{}_{}", dir, row.label, seed);
  std::replace(stem.begin(), stem.end(), ' ', '_');
  const auto live = judge(track.live, track.truth, track.truth.back().t);
  const auto smoothed = judge(track.smoothed, track.truth, track.truth.back().t);
  if (!live || !smoothed) return;
  const AxisErrors best = axis_errors(*live, best_alignment(*live));
  const AxisErrors start = axis_errors(*live, start_alignment(*live));
  const AxisErrors after = axis_errors(*smoothed, best_alignment(*smoothed));
  const std::vector<double> sigma_m = axial_sigmas(*live, pair_after(live->pairs, kSettle_s));
  auto scans = fmt::output_file(stem + "_sweeps.csv");
  scans.print(
      "t_s,axial_m,axial_start_m,axial_sigma_m,lateral_m,vertical_m,axial_smoothed_m,blind,"
      "correction_m,cpu_ms\n");
  for (std::size_t i = 0; i < live->pairs.size(); ++i) {
    const std::size_t k = live->pairs[i].est_index;
    scans.print("{:.3f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{},{:.4f},{:.2f}\n",
                seconds_between(track.t_start, live->pairs[i].t), best.axial[i], start.axial[i],
                sigma_m[i], best.lateral[i], best.vertical[i],
                i < after.axial.size() ? after.axial[i] : 0.0, track.live[k].degenerate ? 1 : 0,
                track.live[k].correction_m, track.cpu_ms[k]);
  }
  auto ranges = fmt::output_file(stem + "_ranges.csv");
  ranges.print("t_s,range_m,error_m,residual_m,sigma_m,bias_m,p_los,reason\n");
  for (const RangeRow& r : track.ranges) {
    ranges.print("{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.2f},{}\n",
                 seconds_between(track.t_start, r.use.sample.t), r.use.sample.range_m, r.error_m,
                 r.use.residual_m, r.use.sigma_m, r.use.bias_m, r.use.p_los,
                 ranging::kRangeReasonNames[static_cast<std::size_t>(r.use.reason)]);
  }
}

}  // namespace rali::tunnel
