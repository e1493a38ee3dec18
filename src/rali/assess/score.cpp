#include "rali/assess/score.hpp"

#include <algorithm>

#include "rali/eval/consistency.hpp"

namespace rali::assess {

using geometry::SE3;

namespace {

/// A gap between evaluated poses longer than this counts as uncovered time.
constexpr double kCoverGap_s = 1.0;

double covered_s(const eval::PairList& pairs) {
  double sum = 0.0;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const double dt = seconds_between(pairs[i - 1].t, pairs[i].t);
    if (dt <= kCoverGap_s) sum += dt;
  }
  return sum;
}

double degenerate_path_m(const eval::PairList& pairs,
                         const std::vector<geometry::Vec3>& degenerate_map) {
  double sum = 0.0;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    if (degenerate_map[pairs[i].est_index].isZero()) continue;
    sum += (pairs[i].ref.p - pairs[i - 1].ref.p).norm();
  }
  return sum;
}

std::optional<NeesScore> nees_score(const std::vector<PoseRow>& rows, int dof,
                                    std::optional<double> PoseRow::*value) {
  std::vector<double> values;
  for (const PoseRow& row : rows) {
    if (row.*value) values.push_back(*(row.*value));
  }
  if (values.empty()) return std::nullopt;
  const double gate = eval::chi2_quantile(0.95, dof);
  const auto within =
      std::count_if(values.begin(), values.end(), [gate](double v) { return v <= gate; });
  NeesScore score;
  score.dof = dof;
  score.poses = values.size();
  score.fraction_within_95 = static_cast<double>(within) / static_cast<double>(values.size());
  const eval::Statistics s = eval::statistics(std::move(values));
  score.mean = s.mean;
  score.median = s.median;
  return score;
}

DegenerateScore degenerate_score(const Samples& samples) {
  std::vector<double> along, across;
  for (const PoseRow& row : samples.rows) {
    if (!row.along_degenerate_m) continue;
    along.push_back(*row.along_degenerate_m);
    across.push_back(row.across_degenerate_m);
  }
  DegenerateScore score{eval::statistics(std::move(along)), eval::statistics(std::move(across)),
                        0.0};
  if (samples.path_m > 0.0) score.path_fraction = samples.degenerate_path_m / samples.path_m;
  return score;
}

}  // namespace

void Samples::append(const Samples& other) {
  rows.insert(rows.end(), other.rows.begin(), other.rows.end());
  rpe.resize(std::max(rpe.size(), other.rpe.size()));
  for (std::size_t d = 0; d < other.rpe.size(); ++d) {
    rpe[d].insert(rpe[d].end(), other.rpe[d].begin(), other.rpe[d].end());
  }
  covariances_unusable += other.covariances_unusable;
  reference_poses += other.reference_poses;
  has_degenerate = has_degenerate || other.has_degenerate;
  path_m += other.path_m;
  degenerate_path_m += other.degenerate_path_m;
  covered_s += other.covered_s;
  truth_s += other.truth_s;
}

Samples samples_of(const eval::PairList& pairs, const std::vector<geometry::Mat6>& covariances,
                   const std::vector<geometry::Vec3>& degenerate_map, const eval::PoseList& truth,
                   const SampleOptions& options) {
  Samples out;
  const SE3& T = options.T_truth_est;
  const std::vector<eval::PoseError> errors = eval::absolute_errors(pairs, T);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const eval::PosePair& p = pairs[i];
    PoseRow row;
    row.t = p.t;
    row.ape_m = errors[i].translation_m;
    row.rot_rad = errors[i].rotation_rad;
    row.error_m = T * p.est.p - p.ref.p;
    if (options.gauge.holds(p)) {
      ++out.reference_poses;
    } else if (p.est_index < covariances.size()) {
      const SE3 truth_est = options.gauge.T_est_ref * p.ref;
      row.nees6 = eval::nees_pose(p.est, truth_est, covariances[p.est_index]);
      row.nees3 = eval::nees_position(p.est, truth_est, covariances[p.est_index]);
      if (!row.nees6) ++out.covariances_unusable;
    }
    out.rows.push_back(row);
  }
  for (const double distance_m : options.distances_m) {
    out.rpe.push_back(eval::relative_errors(pairs, {distance_m, options.all_pairs, 0.1, false}));
  }
  out.has_degenerate = !degenerate_map.empty();
  for (const eval::DegenerateError& e : eval::degenerate_errors(pairs, T, degenerate_map)) {
    out.rows[e.pair].along_degenerate_m = e.along_m;
    out.rows[e.pair].across_degenerate_m = e.across_m;
  }
  out.path_m = eval::path_length_m(pairs);
  if (out.has_degenerate) out.degenerate_path_m = degenerate_path_m(pairs, degenerate_map);
  out.covered_s = covered_s(pairs);
  out.truth_s = truth.empty() ? 0.0 : seconds_between(truth.front().t, truth.back().t);
  return out;
}

TrackScore score_of(const Samples& samples, const std::vector<double>& distances_m) {
  TrackScore score;
  score.poses = samples.rows.size();
  score.path_m = samples.path_m;
  score.time_fraction = samples.truth_s > 0.0 ? std::min(1.0, samples.covered_s / samples.truth_s)
                                              : (samples.rows.empty() ? 0.0 : 1.0);
  std::vector<double> ape, rotation;
  for (const PoseRow& row : samples.rows) {
    ape.push_back(row.ape_m);
    rotation.push_back(row.rot_rad);
  }
  score.ape_m = eval::statistics(std::move(ape));
  score.rotation_rad = eval::statistics(std::move(rotation));
  for (std::size_t d = 0; d < samples.rpe.size() && d < distances_m.size(); ++d) {
    score.rpe.push_back({distances_m[d], eval::translation_statistics(samples.rpe[d]),
                         eval::rotation_statistics(samples.rpe[d])});
  }
  if (samples.has_degenerate) score.degenerate = degenerate_score(samples);
  score.nees6 = nees_score(samples.rows, 6, &PoseRow::nees6);
  score.nees3 = nees_score(samples.rows, 3, &PoseRow::nees3);
  score.covariances_unusable = samples.covariances_unusable;
  score.reference_poses = samples.reference_poses;
  return score;
}

}  // namespace rali::assess
