#include "slam_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "rali/eval/alignment.hpp"
#include "rali/eval/errors.hpp"

namespace rali::ranges_bench {

namespace {

eval::PairList paired(const SlamProblem& problem, const eval::PoseList& estimate) {
  eval::PairList out;
  for (std::size_t k = 0; k < estimate.size(); ++k) {
    out.push_back({estimate[k].t, estimate[k].T, problem.truth[k].T, k});
  }
  return out;
}

Result<geometry::SE3> aligned(const SlamProblem& problem, const eval::PairList& pairs) {
  return eval::align(pairs, problem.planar ? eval::Alignment::kYaw : eval::Alignment::kSe3);
}

double beacons_off_m(const SlamProblem& problem, const SlamEstimate& estimate) {
  const auto T = aligned(problem, paired(problem, estimate.poses));
  double off_m = std::numeric_limits<double>::quiet_NaN();
  if (!T) return off_m;
  for (const auto& [number, p] : estimate.beacons_m) {
    const double distance_m = (*T * p - problem.beacons_m.at(number)).norm();
    if (std::isfinite(distance_m))
      off_m = std::isfinite(off_m) ? std::max(off_m, distance_m) : distance_m;
  }
  return off_m;
}

double sigma_reported_m(const SlamProblem& problem) {
  double square_m2 = 0.0;
  for (const TrackRange& range : problem.ranges) square_m2 += range.sigma_m * range.sigma_m;
  return std::sqrt(square_m2 / static_cast<double>(problem.ranges.size()));
}

/// Separates errors due to the initial values from errors due to the ranges.
void start_at_truth(const SlamProblem& problem, SlamScores& out) {
  // In odom the first pose is the identity; known points are in world.
  const geometry::SE3 T_odom_world =
      problem.known_points() ? geometry::SE3() : problem.truth.front().T.inverse();
  eval::PoseList poses = problem.truth;
  for (eval::StampedPose& pose : poses) pose.T = T_odom_world * pose.T;
  std::map<int, geometry::Vec3> places;
  for (const auto& [beacon, p] : problem.beacons_m) places.emplace(beacon, T_odom_world * p);
  const SlamEstimate estimate = solve_batch(problem, poses, places);
  out.ape_from_truth_m = ape_rmse_m(problem, estimate.poses).value_or(std::nan(""));
  out.cost_from_truth = estimate.cost;
}

std::string number(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
}

}  // namespace

Result<double> ape_rmse_m(const SlamProblem& problem, const eval::PoseList& estimate) {
  const eval::PairList pairs = paired(problem, estimate);
  const auto T = aligned(problem, pairs);
  if (!T) return tl::make_unexpected(T.error());
  return eval::translation_statistics(eval::absolute_errors(pairs, *T)).rmse;
}

Result<SlamScores> run_problem(const SlamProblem& problem) {
  // The vehicle's smallest window; older poses stay as a prior.
  constexpr std::size_t kWindow = 20;
  SlamScores out;
  out.name = problem.name;
  out.poses = problem.truth.size();
  out.ranges = problem.ranges.size();
  out.range_rms_m = range_rms_m(problem);
  out.sigma_m = sigma_reported_m(problem);
  out.steps_nees = steps_nees(problem);
  eval::PoseList initial = odometry_alone(problem);
  out.path_m = eval::path_length_m(paired(problem, initial));
  const auto alone_m = ape_rmse_m(problem, initial);
  if (!alone_m) return tl::make_unexpected(alone_m.error());
  const std::map<int, PlacedBeacon> placed =
      problem.known_points() ? std::map<int, PlacedBeacon>() : place_beacons(problem, initial);
  out.beacons = placed.size();
  for (const auto& [beacon, place] : placed) out.certain += place.certain ? 1 : 0;
  SlamEstimate batch = solve_batch_from(problem, initial, placed);
  const geometry::SE3 T_start =
      problem.known_points() ? place_frame(problem, initial, kFewRanges) : geometry::SE3();
  const SlamEstimate window = solve_window(problem, T_start, kWindow);
  if (window.beacons_m.size() == problem.beacons_m.size()) {
    // The incremental solution was corrected by ranges: a better start where odometry drifts far.
    SlamEstimate other = solve_batch(problem, window.poses, window.beacons_m);
    if (other.cost < batch.cost) batch = std::move(other);
  }
  out.ape_odometry_m = *alone_m;
  out.ape_batch_m = ape_rmse_m(problem, batch.poses).value_or(std::nan(""));
  if (out.steps_nees > 0.0 && out.range_rms_m > 1e-6) {
    const SlamEstimate measured = solve_batch_from(with_measured_sigmas(problem), initial, placed);
    out.ape_measured_m = ape_rmse_m(problem, measured.poses).value_or(std::nan(""));
  }
  out.ape_window_m = ape_rmse_m(problem, window.poses).value_or(std::nan(""));
  out.beacons_off_m = beacons_off_m(problem, batch);
  out.innovations = window.innovations;
  out.cost = batch.cost;
  start_at_truth(problem, out);
  return out;
}

Result<std::vector<SlamProblem>> read_problems(const std::filesystem::path& folder) {
  std::vector<SlamProblem> out;
  const auto take = [&out](Result<SlamProblem> problem) -> Status {
    if (problem) {
      out.push_back(std::move(*problem));
    } else if (problem.error().code != ErrorCode::kNoAnswer) {
      return tl::make_unexpected(problem.error());
    }
    return {};
  };
  for (const std::string name :
       {"factor_graph_small", "plaza2", "single_drone", "tiers", "mrclam3b", "mrclam5a"}) {
    const auto file = read_pyfg(folder / (name + ".pyfg"));
    if (!file) return tl::make_unexpected(file.error());
    for (const auto& [ends, words] : {std::pair(Ends::kBeacons, "to beacons"),
                                      std::pair(Ends::kStanding, "to a standing robot"),
                                      std::pair(Ends::kKnownRobots, "to robots, true places")}) {
      for (const char robot : robots_of(*file)) {
        const std::string title = fmt::format("{} {} {}", name, robot, words);
        if (auto ok = take(problem_of(*file, title, robot, ends)); !ok) {
          return tl::make_unexpected(ok.error());
        }
      }
    }
    if (name != "plaza2" || out.empty()) continue;
    SlamProblem raw = out.back();
    raw.name = "plaza2 A, raw ranges";
    if (auto ok = take(with_raw_ranges(std::move(raw), folder / "Plaza2_TD.txt")); !ok) {
      return tl::make_unexpected(ok.error());
    }
  }
  return out;
}

namespace {

/// True if a is lower than b by more than rounding and early stopping explain.
bool lower(double a, double b) { return a < b - std::max(0.1, 0.01 * b); }

std::string row(const SlamScores& s) {
  const auto n = static_cast<double>(s.innovations.count);
  const bool any = s.innovations.count > 0;
  const auto mean = [&](double sum) { return any ? sum / n : std::nan(""); };
  std::string out =
      fmt::format("| {} | {} | {:.0f} | {} | {} | {:.3f} | {:.2f} | {} |", s.name, s.poses,
                  s.path_m, s.ranges, number(s.range_rms_m, 3), s.sigma_m, s.steps_nees,
                  s.beacons == 0 ? "-" : fmt::format("{} of {}", s.certain, s.beacons));
  out += fmt::format(" {:.3f} | {} | {}{} | {} | {} | {} |", s.ape_odometry_m,
                     number(s.ape_batch_m, 3), number(s.ape_from_truth_m, 3),
                     lower(s.cost_from_truth, s.cost) ? " *" : "", number(s.ape_measured_m, 3),
                     number(s.ape_window_m, 3), number(s.beacons_off_m, 2));
  return out + fmt::format(" {} | {} | {} | {} |\n", number(mean(s.innovations.sum_m), 3),
                           number(std::sqrt(mean(s.innovations.square_m2)), 3),
                           number(mean(s.innovations.nis), 2),
                           number(mean(100.0 * static_cast<double>(s.innovations.beyond)), 1));
}

}  // namespace

std::string slam_table(const std::vector<SlamScores>& scores) {
  std::string out =
      "| track | poses | way m | ranges | rms error m | sigma told m | steps NEES | beacons found "
      "| "
      "odometry alone m | all at once m | from truth m | sigmas as measured m | window m | beacon "
      "off m | innovation mean "
      "m "
      "| rms m | NIS | beyond gate % |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const SlamScores& s : scores) out += row(s);
  return out;
}

}  // namespace rali::ranges_bench
