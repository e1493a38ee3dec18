#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "common/cpu_time.hpp"
#include "drive.hpp"
#include "parts.hpp"
#include "rali/fleet/frames/frame_solver.hpp"

namespace rali::frames_bench {

using fleet::kDegree;
using fleet::YawPose;
using geometry::Vec2;
using geometry::Vec3;

namespace {

constexpr double kStep_s = 0.2, kSpeed_mps = 0.7, kDuration_s = 120.0, kEvery_s = 4.0;
constexpr double kSigma_m = 0.1, kBias_m = 0.15;
/// A committed frame with a larger error is wrong.
constexpr double kWrong_m = 1.0, kWrong_deg = 10.0;
/// Fraction and largest excess of ranges with an obstructed line of sight.
constexpr double kBlockedFraction = 0.1, kExcess_m = 1.5;

enum class Path { kRandom, kStraight, kStand, kStandThenL };

struct Scenario {
  const char* name;
  std::vector<Path> paths;
  bool chain = false;    ///< each vehicle ranges only with its neighbour in the list
  bool blocked = false;  ///< some ranges are too long
};

std::vector<Scenario> scenarios() {
  return {
      {"both drive", {Path::kRandom, Path::kRandom}, false, false},
      {"both drive, 10 % of ranges up to 1.5 m too long",
       {Path::kRandom, Path::kRandom},
       false,
       true},
      {"anchor stands 40 s, then L 4 + 4", {Path::kStandThenL, Path::kRandom}, false, false},
      {"anchor stands", {Path::kStand, Path::kRandom}, false, false},
      {"anchor stands, tag straight", {Path::kStand, Path::kStraight}, false, false},
      {"both straight", {Path::kStraight, Path::kStraight}, false, false},
      {"three drive, the third hears the second only",
       {Path::kRandom, Path::kRandom, Path::kRandom},
       true,
       false},
  };
}

/// A position every kStep_s.
std::vector<Vec2> path_of(Path kind, Rng& rng) {
  const auto n = static_cast<std::size_t>(kDuration_s / kStep_s);
  const double length_m = kSpeed_mps * kDuration_s;
  if (kind == Path::kStand) return std::vector<Vec2>(n, Vec2::Zero());
  if (kind == Path::kStraight) return way_through({{0, 0}, {length_m, 0}}, n);
  if (kind == Path::kStandThenL) {
    std::vector<Vec2> out(n / 3, Vec2::Zero());
    const auto moving = static_cast<std::size_t>(8.0 / kSpeed_mps / kStep_s);
    const double side = rng.below(2) == 0 ? -1.0 : 1.0;
    for (const Vec2& p : way_through({{0, 0}, {4, 0}, {4, 4 * side}}, moving)) out.push_back(p);
    out.resize(n, out.back());
    return out;
  }
  std::vector<Vec2> corners = {{0, 0}};
  double heading = 0.0;
  double driven_m = 0.0;
  while (driven_m < length_m) {
    const double leg_m = std::min(rng.uniform(3.0, 8.0), length_m - driven_m + 1e-3);
    corners.push_back(corners.back() + leg_m * Vec2(std::cos(heading), std::sin(heading)));
    driven_m += leg_m;
    heading += (rng.below(2) == 0 ? -1.0 : 1.0) * rng.uniform(30.0, 120.0) * kDegree;
  }
  return way_through(corners, n);
}

struct Tally {
  int committed = 0, wrong = 0, wanted = 0;
  std::vector<double> place_m, yaw_deg, time_s, nees;
  double ms = 0.0;
  int evaluations = 0;
};

/// One start: vehicles anywhere within 20 m of the first, at any heading.
class Start {
 public:
  Start(const Scenario& scenario, bool prior, std::uint64_t seed)
      : scenario_(scenario), rng_(seed, scenario.name), solver_(settings_, key(0)) {
    for (std::size_t v = 0; v < scenario.paths.size(); ++v) {
      drives_.push_back(drive_along(path_of(scenario.paths[v], rng_), DriveErrors{}, rng_));
      const Vec3 at(rng_.uniform(-14.0, 14.0), rng_.uniform(-14.0, 14.0), 0.0);
      T_world_odom_.push_back({rng_.uniform(-3.14, 3.14), at});
      biases_m_.push_back(kBias_m * rng_.normal());
      found_.push_back(false);
    }
    if (prior) add_priors();
  }

  void run(Tally& tally) {
    const std::size_t n = drives_.front().true_m.size();
    const auto every = static_cast<std::size_t>(kEvery_s / kStep_s);
    tally.wanted += static_cast<int>(drives_.size()) - 1;
    for (std::size_t k = 0; k < n; ++k) {
      listen(k);
      if (k % every != 0) continue;
      const double start_ms = bench::cpu_ms();
      solver_.evaluate(Time::from_s(kStep_s * static_cast<double>(k)));
      tally.ms += bench::cpu_ms() - start_ms;
      ++tally.evaluations;
      if (look(kStep_s * static_cast<double>(k), tally)) return;
    }
  }

 private:
  static fleet::StreamKey key(std::size_t v) {
    return {VehicleId{static_cast<std::uint16_t>(v + 1)}, 0};
  }

  [[nodiscard]] YawPose truth(std::size_t ref, std::size_t v) const {
    return T_world_odom_[ref].inverse() * T_world_odom_[v];
  }

  void add_priors() {
    for (std::size_t v = 1; v < drives_.size(); ++v) {
      YawPose T = truth(0, v);
      T.yaw_rad += settings_.prior.yaw_deg * kDegree * rng_.normal();
      T.t_m += settings_.prior.xyz_m * Vec3(rng_.normal(), rng_.normal(), 0.0);
      solver_.add_evidence(fleet::prior_evidence(key(v), key(0), T, settings_));
    }
  }

  void listen(std::size_t k) {
    for (std::size_t b = 0; b < drives_.size(); ++b) {
      for (std::size_t a = b + 1; a < drives_.size(); ++a) {
        if (scenario_.chain && a != b + 1) continue;
        fleet::RangeObservation o =
            observe(drives_[a], drives_[b], truth(b, a), k, kStep_s * static_cast<double>(k),
                    biases_m_[a], kSigma_m, rng_);
        if (scenario_.blocked && rng_.uniform() < kBlockedFraction) {
          o.range_m += rng_.uniform(0.0, kExcess_m);
        }
        solver_.add_range(key(a), key(b), o);
      }
    }
  }

  /// @return true if all are initialised
  bool look(double t_s, Tally& tally) {
    bool all = true;
    for (std::size_t v = 1; v < drives_.size(); ++v) {
      if (found_[v]) continue;
      const auto T = solver_.T_ref_odom(key(v));
      if (!T) {
        all = false;
        continue;
      }
      found_[v] = true;
      const YawPose T_true = truth(0, v);
      // Both at the time of the commitment, since the frame is used from then on.
      const double place_m = (T->t_m - T_true.t_m).norm();
      const double yaw_deg = std::abs(fleet::wrapped(T->yaw_rad - T_true.yaw_rad)) / kDegree;
      tally.place_m.push_back(place_m);
      tally.yaw_deg.push_back(yaw_deg);
      tally.time_s.push_back(t_s);
      ++tally.committed;
      if (place_m > kWrong_m || yaw_deg > kWrong_deg) {
        ++tally.wrong;
        fmt::print(stderr, "WRONG: {}: {:.2f} m, {:.1f} deg at {:.0f} s\n", scenario_.name, place_m,
                   yaw_deg, t_s);
      }
      tally.nees.push_back(nees(v, *T, T_true));
    }
    return all;
  }

  /// Normalised estimation error squared of (yaw, x, y), per degree of freedom.
  [[nodiscard]] double nees(std::size_t v, const YawPose& T, const YawPose& T_true) const {
    const fleet::FleetFrames frames = solver_.frames();
    const fleet::SolvedGroup& group = frames.groups.front();
    const auto at = std::find(group.frames.keys.begin(), group.frames.keys.end(), key(v));
    const Eigen::Index from = 4 * (at - group.frames.keys.begin() - 1);
    const Eigen::Vector3d d(fleet::wrapped(T.yaw_rad - T_true.yaw_rad), T.t_m.x() - T_true.t_m.x(),
                            T.t_m.y() - T_true.t_m.y());
    const Eigen::Matrix3d C = group.covariance.block<3, 3>(from, from);
    return d.dot(C.ldlt().solve(d)) / 3.0;
  }

  const Scenario& scenario_;
  Rng rng_;
  fleet::InitSettings settings_;
  fleet::FrameSolver solver_;
  std::vector<Drive> drives_;
  std::vector<YawPose> T_world_odom_;
  std::vector<double> biases_m_;
  std::vector<bool> found_;
};

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

}  // namespace

std::string start_table(int starts) {
  std::string out = fmt::format(
      "{} starts within 14 m along each axis, any heading; {} m/s, a range each {} s of sigma {} "
      "m, "
      "pair bias of sd {} m, odometry with {} % and {} deg/sqrt(m); {} s at most. Wrong: farther "
      "off "
      "than {} m or {} deg.\n\n"
      "| vehicles | prior | committed | wrong | place m: median, rms, max | yaw deg: rms, max | "
      "NEES | "
      "time to commit s: median, max | ms per evaluation "
      "|\n|---|---|---|---|---|---|---|---|---|\n",
      starts, kSpeed_mps, kStep_s, kSigma_m, kBias_m, 100.0 * DriveErrors{}.scale,
      DriveErrors{}.yaw_deg_per_sqrt_m, kDuration_s, kWrong_m, kWrong_deg);
  for (const Scenario& scenario : scenarios()) {
    for (const bool prior : {false, true}) {
      Tally t;
      for (int k = 0; k < starts; ++k) {
        Start(scenario, prior, static_cast<std::uint64_t>(k)).run(t);
      }
      const std::string row = fmt::format(
          "| {} | {} | {} of {} | {} | {:.2f}, {:.2f}, {:.2f} | {:.2f}, {:.2f} | {:.2f} | {:.0f}, "
          "{:.0f} | {:.0f} |\n",
          scenario.name, prior ? "yes" : "no", t.committed, t.wanted, t.wrong, median(t.place_m),
          rms(t.place_m), largest(t.place_m), rms(t.yaw_deg), largest(t.yaw_deg), mean(t.nees),
          median(t.time_s), largest(t.time_s), t.ms / std::max(1, t.evaluations));
      // A row takes minutes, so it is shown at once.
      fmt::print(stderr, "{}", row);
      out += row;
    }
  }
  return out;
}

}  // namespace rali::frames_bench
