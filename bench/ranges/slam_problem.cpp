#include "slam_problem.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/LU>
#include <fmt/format.h>

#include "number_rows.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::ranges_bench {

using geometry::Vec3;

namespace {

/// Largest apparent motion of a stationary robot.
constexpr double kStands_m = 0.05;

bool stands(const Pyfg& file, char robot) {
  std::optional<Vec3> first;
  for (const auto& [name, pose] : file.poses) {
    if (name.robot != robot) continue;
    if (!first) first = pose.T.p;
    if ((pose.T.p - *first).norm() > kStands_m) return false;
  }
  return first.has_value();
}

using PoseIndex = std::map<int, std::size_t>;  ///< number in the file to index in the track

Status take_steps(const Pyfg& file, char robot, const PoseIndex& index, SlamProblem& out) {
  std::vector<bool> there(out.truth.size(), false);
  out.steps.resize(out.truth.size() - 1);
  for (const PyfgStep& s : file.steps) {
    if (s.from.robot != robot || s.to.robot != robot) continue;
    const std::size_t i = index.at(s.from.index);
    if (index.at(s.to.index) != i + 1) continue;
    graph::RelativePoseFactor& f = out.steps[i];
    f.i = static_cast<graph::Seq>(i);
    f.j = static_cast<graph::Seq>(i + 1);
    f.T_i_j = s.T_from_to;
    f.information = s.covariance.inverse();
    there[i] = true;
  }
  for (std::size_t i = 0; i + 1 < out.truth.size(); ++i) {
    if (!there[i]) {
      return fail(ErrorCode::kInput, out.name, fmt::format("no odometry after pose {}", i));
    }
  }
  return {};
}

/// A stationary robot is a beacon with a number that no landmark has.
int number_of_robot(char robot) { return 1000 + (robot - 'A'); }

/// The range from the robot's point of view; empty if it has no part in it or the kind differs.
std::optional<TrackRange> own_range(const Pyfg& file, const PyfgRange& r, char robot, Ends ends,
                                    const PoseIndex& index, SlamProblem& out) {
  if ((r.from.robot == robot) == (r.to.robot == robot)) return std::nullopt;
  const PyfgName own = r.from.robot == robot ? r.from : r.to;
  const PyfgName other = r.from.robot == robot ? r.to : r.from;
  const bool landmark = file.landmarks_m.contains(other);
  if (landmark != (ends == Ends::kBeacons)) return std::nullopt;
  TrackRange range;
  range.t = r.t;
  range.pose = index.at(own.index);
  range.range_m = r.range_m;
  range.sigma_m = std::sqrt(r.variance_m2);
  if (ends == Ends::kKnownRobots) {
    range.p_known_m = file.poses.at(other).T.p;
    return range;
  }
  if (ends == Ends::kStanding && !stands(file, other.robot)) return std::nullopt;
  range.beacon = landmark ? other.index : number_of_robot(other.robot);
  out.beacons_m.emplace(*range.beacon,
                        landmark ? file.landmarks_m.at(other) : file.poses.at(other).T.p);
  return range;
}

}  // namespace

std::vector<char> robots_of(const Pyfg& file) {
  std::vector<char> out;
  for (const auto& [name, pose] : file.poses) {
    if (out.empty() || out.back() != name.robot) out.push_back(name.robot);
  }
  return out;
}

Result<SlamProblem> problem_of(const Pyfg& file, const std::string& name, char robot, Ends ends) {
  SlamProblem out;
  out.name = name;
  out.planar = file.planar;
  PoseIndex index;
  Time t_last;
  for (const auto& [pose_name, pose] : file.poses) {
    if (pose_name.robot != robot) continue;
    if (!out.truth.empty() && pose.t < t_last) {
      return fail(ErrorCode::kInput, name, fmt::format("pose {} is not later", pose_name.index));
    }
    t_last = pose.t;
    index.emplace(pose_name.index, out.truth.size());
    // Where motion capture was late (tiers) several poses have one stamp; only the order matters.
    const Time t =
        out.truth.empty() ? pose.t : std::max(pose.t, out.truth.back().t + Duration::from_ns(1));
    out.truth.push_back({t, pose.T});
  }
  if (stands(file, robot)) return fail(ErrorCode::kNoAnswer, name, "this robot stands");
  if (out.truth.size() < 2) return fail(ErrorCode::kNoAnswer, name, "no track of this robot");
  if (auto ok = take_steps(file, robot, index, out); !ok) return tl::make_unexpected(ok.error());
  for (const PyfgRange& r : file.ranges) {
    if (auto range = own_range(file, r, robot, ends, index, out)) out.ranges.push_back(*range);
  }
  if (out.ranges.empty()) return fail(ErrorCode::kNoAnswer, name, "no range of this kind");
  std::stable_sort(out.ranges.begin(), out.ranges.end(),
                   [](const TrackRange& a, const TrackRange& b) { return a.pose < b.pose; });
  return out;
}

namespace {

/// The beacon of each receiver in the raw file: ranges of the same time are the same range.
std::map<int, int> beacons_of(const SlamProblem& plaza, const NumberRows& raw) {
  std::map<Time, int> at;
  for (const TrackRange& range : plaza.ranges) at.emplace(range.t, range.beacon.value_or(-1));
  std::map<int, int> out;
  for (const std::vector<double>& row : raw.rows) {
    const Time t = Time::from_s(row[0]);
    const auto found = at.lower_bound(t - Duration::from_s(1e-6));
    if (found == at.end() || found->first > t + Duration::from_s(1e-6)) continue;
    if (row[2] >= 0.0 && row[2] < 1e6) out.emplace(static_cast<int>(row[2]), found->second);
  }
  return out;
}

}  // namespace

Result<SlamProblem> with_raw_ranges(SlamProblem plaza, const std::filesystem::path& path) {
  const auto table = read_number_rows(path, ' ');
  if (!table) return tl::make_unexpected(table.error());
  if (table->rows.front().size() != 4) {
    return fail(ErrorCode::kInput, path.string(), "a row should have four numbers");
  }
  const std::map<int, int> beacons = beacons_of(plaza, *table);
  const double sigma_m = plaza.ranges.front().sigma_m;
  plaza.ranges.clear();
  for (const std::vector<double>& row : table->rows) {
    TrackRange range;
    range.t = Time::from_s(row[0]);
    const auto after =
        std::upper_bound(plaza.truth.begin(), plaza.truth.end(), range.t,
                         [](Time t, const eval::StampedPose& pose) { return t < pose.t; });
    if (after == plaza.truth.begin() || !std::isfinite(row[3]) || !(std::abs(row[2]) < 1e6))
      continue;
    const auto beacon = beacons.find(static_cast<int>(row[2]));
    if (beacon == beacons.end()) continue;
    range.pose = static_cast<std::size_t>(after - plaza.truth.begin()) - 1;
    range.beacon = beacon->second;
    range.range_m = row[3];
    range.sigma_m = sigma_m;
    plaza.ranges.push_back(range);
  }
  plaza.bias_sigma_m = 3.0;
  if (plaza.ranges.empty()) return fail(ErrorCode::kNoAnswer, path.string(), "no range in it");
  return plaza;
}

namespace {

/// Mean squares of the steps' errors by their covariance, per estimated degree of freedom.
struct StepSquares {
  double rotation = 0.0, translation = 0.0;
};

StepSquares step_squares(const SlamProblem& problem) {
  StepSquares sum;
  const int axes = problem.planar ? 2 : 3;
  for (std::size_t k = 0; k < problem.steps.size(); ++k) {
    const graph::RelativePoseFactor& f = problem.steps[k];
    const geometry::SE3 between = problem.truth[k].T.inverse() * problem.truth[k + 1].T;
    const geometry::Mat6 C = f.information.inverse();
    const Vec3 turn = geometry::so3_log(f.T_i_j.R.transpose() * between.R);
    const Vec3 off = between.p - f.T_i_j.p;
    for (int d = 0; d < axes; ++d) sum.translation += off[d] * off[d] / C(3 + d, 3 + d) / axes;
    for (int d = problem.planar ? 2 : 0; d < 3; ++d) {
      sum.rotation += turn[d] * turn[d] / C(d, d) / (problem.planar ? 1 : 3);
    }
  }
  const auto n = static_cast<double>(problem.steps.size());
  return {sum.rotation / n, sum.translation / n};
}

}  // namespace

double steps_nees(const SlamProblem& problem) {
  const StepSquares s = step_squares(problem);
  return problem.planar ? (s.rotation + 2.0 * s.translation) / 3.0
                        : 0.5 * (s.rotation + s.translation);
}

double range_rms_m(const SlamProblem& problem) {
  double square_m2 = 0.0;
  for (const TrackRange& range : problem.ranges) {
    const Vec3& to = range.beacon ? problem.beacons_m.at(*range.beacon) : range.p_known_m;
    const double error_m = range.range_m - (problem.truth[range.pose].T.p - to).norm();
    square_m2 += error_m * error_m;
  }
  return std::sqrt(square_m2 / static_cast<double>(problem.ranges.size()));
}

SlamProblem with_measured_sigmas(SlamProblem problem) {
  const StepSquares s = step_squares(problem);
  geometry::Vec6 shrink;
  shrink.head<3>().setConstant(1.0 / std::sqrt(s.rotation));
  shrink.tail<3>().setConstant(1.0 / std::sqrt(s.translation));
  // The sigmas of z, roll and pitch that enforce the plane stay unchanged.
  if (problem.planar) shrink[0] = shrink[1] = shrink[5] = 1.0;
  for (graph::RelativePoseFactor& f : problem.steps) {
    f.information = geometry::Mat6(shrink.asDiagonal() * f.information * shrink.asDiagonal());
  }
  const double sigma_m = range_rms_m(problem);
  for (TrackRange& range : problem.ranges) range.sigma_m = sigma_m;
  return problem;
}

eval::PoseList odometry_alone(const SlamProblem& problem) {
  eval::PoseList out{{problem.truth.front().t, {}}};
  for (std::size_t k = 0; k < problem.steps.size(); ++k) {
    out.push_back({problem.truth[k + 1].t, out.back().T * problem.steps[k].T_i_j});
  }
  return out;
}

}  // namespace rali::ranges_bench
