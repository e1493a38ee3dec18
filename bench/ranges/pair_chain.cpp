#include "pair_chain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Core>
#include <fmt/format.h>

#include "rali/base/rng.hpp"
#include "rali/eval/statistics.hpp"
#include "rali/ranging/excess_watch.hpp"
#include "rali/ranging/range_link.hpp"
#include "rali/ranging/range_model.hpp"
#include "rali/ranging/range_sanity.hpp"
#include "rali/ranging/range_thinning.hpp"
#include "rali/ranging/sight_turn.hpp"
#include "rali/ranging/signal_quality.hpp"

namespace rali::ranges_bench {

using ranging::RangeReason;

namespace {

constexpr double kBad_m = 0.3;
constexpr double kGross_m = 1.0;
constexpr double kWidenMax = 16.0;  // as the range stage

/// Filter states of one pair: error of the predicted distance, which other sensors keep within its
/// sigma, and the pair's bias. The offset of a range from the predicted distance is their sum.
class OffsetFilter {
 public:
  OffsetFilter(const ChainOptions& o, double d_true_m) : options_(o), d_true_m_(d_true_m) {
    P_.diagonal() << variance(), o.ranging.bias.sigma_m * o.ranging.bias.sigma_m;
  }

  /// Propagates the estimate and the true error, a first-order Gauss-Markov process.
  void advance(double dt_s, Rng& rng) {
    const double drift = options_.drift_m_rts * options_.drift_m_rts;
    const double a = std::exp(-0.5 * drift / variance() * dt_s);
    const double gained = (1.0 - a * a) * variance();
    d_true_m_ = a * d_true_m_ + std::sqrt(gained) * rng.normal();
    x_[0] *= a;
    P_.row(0) *= a;
    P_.col(0) *= a;
    P_(0, 0) += gained;
    const double walk = options_.ranging.bias.walk_m_rts;
    P_(1, 1) += walk * walk * dt_s;
  }

  [[nodiscard]] double residual_m(double error_m) const { return error_m + d_true_m_ - offset_m(); }

  [[nodiscard]] double offset_variance_m2() const { return H_.dot(P_ * H_.transpose()); }

  void update(double nu_m, double R_m2) {
    const Eigen::Vector2d PHt = P_ * H_.transpose();
    const Eigen::Vector2d K = PHt / (H_.dot(PHt) + R_m2);
    x_ += K * nu_m;
    P_ -= K * PHt.transpose();
  }

  void widen(double factor) {
    P_.row(0) *= std::sqrt(factor);
    P_.col(0) *= std::sqrt(factor);
  }

  /// Error of the estimated offset, given the pair's constant error.
  [[nodiscard]] double offset_error_m(double bias_m) const {
    return offset_m() - (bias_m + d_true_m_);
  }

  [[nodiscard]] double nees_distance() const {
    const double error_m = x_[0] - d_true_m_;
    return error_m * error_m / P_(0, 0);
  }

 private:
  [[nodiscard]] double variance() const {
    return options_.position_sigma_m * options_.position_sigma_m;
  }

  [[nodiscard]] double offset_m() const { return H_.dot(x_); }

  ChainOptions options_;
  double d_true_m_ = 0.0;
  Eigen::Vector2d x_ = Eigen::Vector2d::Zero();
  Eigen::Matrix2d P_ = Eigen::Matrix2d::Zero();
  Eigen::RowVector2d H_{1.0, 1.0};
};

/// The chain of one pair (vehicle/range_stage.cpp).
class Chain {
 public:
  Chain(const ChainOptions& options, double d_true_m)
      : options_(options),
        filter(options, d_true_m),
        sanity_(options.ranging.limits, options.ranging.sanity),
        link_(options.ranging.gate, options.ranging.link),
        thinning_(options.ranging.slow),
        excess_(options.ranging.excess) {}

  /// Sets R_m2 to the variance used, if the range is used.
  RangeReason use(const PairRange& range, double rate_mps, bool at_rest, double& R_m2) {
    const ranging::RangingSettings& r = options_.ranging;
    double sigma_m = ranging::sigma_of(range.range_m, r.limits, 0.0);
    if (const auto wrong = sanity_.check(range.t, range.range_m, sigma_m, rate_mps)) return *wrong;
    sensor::RangeSample sample;
    sample.rssi_dbm = range.rssi_dbm;
    sample.first_path_dbm = range.first_path_dbm;
    const ranging::SignalQuality signal = ranging::signal_quality(sample, r.signal);
    sigma_m *= signal.sigma_factor;
    const double nu_m = filter.residual_m(range.range_m - range.true_m);
    const double H_P_H = filter.offset_variance_m2();
    if (is_excess(range, rate_mps, sigma_m, std::sqrt(H_P_H))) return RangeReason::kNlos;
    const ranging::LinkDecision decision =
        link_.decide({range.t, nu_m, H_P_H + sigma_m * sigma_m, sigma_m, signal.clear()});
    if (decision.advice == ranging::LinkAdvice::kWeAreWrong) widen(decision.widen_factor);
    if (!decision.use) return decision.reason;
    R_m2 = decision.gate.R_m2 * thinning_.inflation(range.t, sigma_m, at_rest);
    filter.update(nu_m, R_m2);
    return RangeReason::kUsed;
  }

  [[nodiscard]] std::size_t widened() const { return widened_; }

 private:
  void widen(double factor) {
    ++widened_;
    filter.widen(factor);
  }

  bool is_excess(const PairRange& range, double rate_mps, double sigma_m, double pose_sigma_m) {
    if (!options_.ranging.excess.use) return false;
    ranging::ExcessSample sample;
    sample.t = range.t;
    sample.range_m = range.range_m;
    if (last_) sample.change_m = rate_mps * seconds_between(*last_, range.t);
    last_ = range.t;
    sample.sigma_m = sigma_m;
    sample.speed_sigma_mps = options_.speed_sigma_mps;
    sample.residual_m = filter.residual_m(range.range_m - range.true_m);
    sample.pose_sigma_m = pose_sigma_m;
    sample.turn_sigma_m = sight_turn_.add(range.t, range.sight).norm() * options_.position_sigma_m;
    const auto verdict = excess_.look(sample);
    if (verdict == ranging::ExcessVerdict::kRelieved) {
      const double was_m = std::max(1e-3, pose_sigma_m);
      const double wrong = excess_.step_m() / was_m;
      widen(std::clamp(1.0 + wrong * wrong, 1.0, kWidenMax));
      return false;
    }
    return verdict != ranging::ExcessVerdict::kNone;
  }

  ChainOptions options_;

 public:
  OffsetFilter filter;

 private:
  ranging::RangeSanity sanity_;
  ranging::RangeLink link_;
  ranging::RangeThinning thinning_;
  ranging::ExcessWatch excess_;
  ranging::SightTurn sight_turn_;
  std::optional<Time> last_;  ///< of the last processed range
  std::size_t widened_ = 0;
};

double median_error_m(const PairRecord& pair) {
  std::vector<double> errors;
  for (const PairRange& range : pair.ranges) errors.push_back(range.range_m - range.true_m);
  return eval::quantile(std::move(errors), 0.5);
}

void count(double error_m, RangeReason reason, double R_m2, ChainScores& out) {
  const bool bad = std::abs(error_m) > kBad_m;
  const bool used = reason == RangeReason::kUsed;
  ++out.ranges;
  ++out.reasons[static_cast<std::size_t>(reason)];
  ++(bad ? out.bad : out.good);
  if (bad && !used) ++out.bad_refused;
  if (std::abs(error_m) > kGross_m) {
    ++out.gross;
    out.gross_refused += used ? 0 : 1;
  }
  if (!bad && used) ++out.good_kept;
  out.square_before_m2 += error_m * error_m;
  if (!used) return;
  out.square_after += error_m * error_m / R_m2;
  out.weight_after += 1.0 / R_m2;
}

}  // namespace

void ChainScores::add(const ChainScores& o) {
  pairs += o.pairs;
  ranges += o.ranges;
  bad += o.bad;
  bad_refused += o.bad_refused;
  gross += o.gross;
  gross_refused += o.gross_refused;
  good += o.good;
  good_kept += o.good_kept;
  for (std::size_t k = 0; k < reasons.size(); ++k) reasons[k] += o.reasons[k];
  widened += o.widened;
  square_before_m2 += o.square_before_m2;
  square_after += o.square_after;
  weight_after += o.weight_after;
  offset_square_m2 += o.offset_square_m2;
  nees_offset += o.nees_offset;
  nees_distance += o.nees_distance;
  offset_in_95 += o.offset_in_95;
}

ChainScores run_chain(const PairRecord& pair, std::uint64_t seed, const ChainOptions& options) {
  ChainScores out;
  if (pair.ranges.empty()) return out;
  out.pairs = 1;
  const double bias_m = median_error_m(pair);
  Rng rng(seed, "ranges_bench");
  Chain chain(options, options.position_sigma_m * rng.normal());
  const PairRange* last = nullptr;
  for (const PairRange& range : pair.ranges) {
    double rate_mps = std::numeric_limits<double>::quiet_NaN();
    if (last != nullptr) {
      const double dt_s = std::max(1e-4, seconds_between(last->t, range.t));
      rate_mps = (range.true_m - last->true_m) / dt_s;
      chain.filter.advance(dt_s, rng);
    }
    last = &range;
    double R_m2 = 0.0;
    const RangeReason reason = chain.use(range, rate_mps, pair.at_rest, R_m2);
    count(range.range_m - range.true_m - bias_m, reason, R_m2, out);
    const double off_m = chain.filter.offset_error_m(bias_m);
    const double nees = off_m * off_m / chain.filter.offset_variance_m2();
    out.offset_square_m2 += off_m * off_m;
    out.nees_offset += nees;
    out.nees_distance += chain.filter.nees_distance();
    out.offset_in_95 += nees < 3.841 ? 1 : 0;
  }
  out.widened = chain.widened();
  return out;
}

ChainScores run_chain(const PairSet& set, const ChainOptions& options) {
  ChainScores out;
  for (std::size_t k = 0; k < set.pairs.size(); ++k) {
    out.add(run_chain(set.pairs[k], k, options));
  }
  return out;
}

namespace {

double fraction(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

/// Sigma of the pose and of a pair's bias: the setting's, and one as wide as the biases of
/// uncalibrated radios.
constexpr std::array<std::pair<double, double>, 4> kConfigurations{
    {{0.05, 0.1}, {0.05, 0.25}, {0.3, 0.1}, {0.3, 0.25}}};

std::string row(const std::string& name, const ChainOptions& o, const ChainScores& s) {
  const double n = std::max(1.0, static_cast<double>(s.ranges));
  const double after_m = std::sqrt(s.square_after / std::max(1e-300, s.weight_after));
  const auto of = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? std::string("-") : fmt::format("{:.1f} %", fraction(part, whole));
  };
  return fmt::format(
      "| {} | {:.0f}, {:.0f} cm | {} | {} | {:.2f} % | {} | {} | {} | {} | {:.3f} | {:.3f} | "
      "{:.3f} | "
      "{:.2f} | "
      "{:.1f} % | {:.2f} | {} |\n",
      name, 100.0 * o.position_sigma_m, 100.0 * o.ranging.bias.sigma_m, s.pairs, s.ranges,
      fraction(s.bad, s.ranges), of(s.bad_refused, s.bad), s.gross, of(s.gross_refused, s.gross),
      of(s.good_kept, s.good), std::sqrt(s.square_before_m2 / n), after_m,
      std::sqrt(s.offset_square_m2 / n), s.nees_offset / n, fraction(s.offset_in_95, s.ranges),
      s.nees_distance / n, s.widened);
}

std::string reasons_row(const std::string& name, const ChainOptions& o, const ChainScores& s) {
  std::string out = fmt::format("| {} | {:.0f}, {:.0f} cm |", name, 100.0 * o.position_sigma_m,
                                100.0 * o.ranging.bias.sigma_m);
  for (const RangeReason reason : {RangeReason::kUsed, RangeReason::kNlos, RangeReason::kOutlier,
                                   RangeReason::kBlockedByGate, RangeReason::kOutOfLimits}) {
    out +=
        fmt::format(" {:.2f} % |", fraction(s.reasons[static_cast<std::size_t>(reason)], s.ranges));
  }
  return out + "\n";
}

}  // namespace

std::string pair_tables(const std::vector<PairSet>& sets) {
  std::string scores =
      "| set | sigma of pose, bias | pairs | ranges | bad | bad refused | beyond 1 m | of these "
      "refused | "
      "good kept | rms before m | rms "
      "after m | offset rms m | NEES offset | in 95 % | NEES distance | widened |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  std::string reasons =
      "| set | sigma of pose, bias | used | nlos | outlier | blocked_by_gate | out_of_limits |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const PairSet& set : sets) {
    for (const auto& [sigma_m, bias_sigma_m] : kConfigurations) {
      ChainOptions options;
      options.position_sigma_m = sigma_m;
      options.ranging.bias.sigma_m = bias_sigma_m;
      const ChainScores s = run_chain(set, options);
      scores += row(set.name, options, s);
      if (bias_sigma_m < 0.2) reasons += reasons_row(set.name, options, s);
    }
  }
  return scores + "\nWhat became of them:\n\n" + reasons;
}

}  // namespace rali::ranges_bench
