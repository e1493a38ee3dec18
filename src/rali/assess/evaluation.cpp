#include "rali/assess/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/assess/frame_fit.hpp"
#include "rali/assess/stamps.hpp"
#include "rali/io/files/cloud_file.hpp"

namespace rali::assess {

using geometry::SE3;

namespace {

/// Two vehicles are compared where both have poses at most this far apart in time.
constexpr double kBetweenGap_s = 0.25;
/// Ground truth with a longer period than this does not follow pitch and roll of a vehicle.
constexpr double kSlowTruth_s = 0.05;
/// A clock shift of at least this is reported if it reduces the error to this fraction.
constexpr double kShiftMin_s = 0.002;
constexpr double kShiftFraction = 0.7;
/// Tolerance as a fraction of the offset added by rali map; covers its sigma and that of the shift.
constexpr double kOffsetFraction = 0.25;

/// A vehicle with its pose pairs, before it is scored.
struct Judged {
  const VehicleInput* input = nullptr;
  bool is_reference = false;  ///< its first pose fixes the frame
  eval::PairList pairs, live_pairs, odometry_pairs;
};

Result<eval::PairList> pairs_of(const eval::PoseList& poses, const VehicleInput& vehicle,
                                const EvaluationOptions& options) {
  Result<eval::Association> found = eval::associate(poses, vehicle.truth, options.associate);
  if (found) return std::move(found->pairs);
  if (found.error().code != ErrorCode::kNoAnswer) {
    Error error = found.error();
    error.where = vehicle.file + ": " + error.where;
    return tl::make_unexpected(std::move(error));
  }
  return tl::make_unexpected(
      no_common_time(poses, vehicle.file, vehicle.truth, vehicle.truth_file, options.associate));
}

Result<Judged> judged(const VehicleInput& vehicle, const EvaluationOptions& options) {
  Judged out;
  out.input = &vehicle;
  Result<eval::PairList> pairs = pairs_of(vehicle.trajectory.poses, vehicle, options);
  if (!pairs) return tl::make_unexpected(pairs.error());
  out.pairs = std::move(*pairs);
  for (const auto& [track, list] : {std::pair{&vehicle.live, &out.live_pairs},
                                    std::pair{&vehicle.odometry, &out.odometry_pairs}}) {
    if (track->poses.empty()) continue;
    pairs = pairs_of(track->poses, vehicle, options);
    if (!pairs) return tl::make_unexpected(pairs.error());
    *list = std::move(*pairs);
  }
  return out;
}

/// Linear interpolation between the poses of a slow ground truth misses motion on rough ground.
void warn_of_slow_truth(const VehicleInput& v, const EvaluationOptions& options,
                        std::vector<std::string>& warnings) {
  if (options.associate.mode != eval::AssociationMode::kInterpolate || v.truth.size() < 2) return;
  std::vector<double> gaps_s;
  for (std::size_t i = 1; i < v.truth.size(); ++i) {
    gaps_s.push_back(seconds_between(v.truth[i - 1].t, v.truth[i].t));
  }
  const double gap_s = eval::quantile(std::move(gaps_s), 0.5);
  if (gap_s < kSlowTruth_s) return;
  warnings.push_back(fmt::format(
      "{}: one pose each {:.2f} s; jolts between them are not in it, so rotation errors, short RPE "
      "and NEES come out too large",
      v.truth_file, gap_s));
}

/// rali map keeps the fleet's clock, that of the IMU: it adds the estimated offset to the LiDAR's
/// stamps. A ground truth on the LiDAR's clock is then shifted by exactly this offset.
std::string cause_of_shift(double shift_s, const VehicleInput& v) {
  const double offset_s = v.time_offset_s;
  if (offset_s == 0.0) return "the clocks or the stamp rules differ";
  const double left_s = std::abs(shift_s + offset_s);
  const bool explains = left_s < std::max(kShiftMin_s, kOffsetFraction * std::abs(offset_s));
  return fmt::format(
      "rali map has added {:+.4f} s to the LiDAR's stamps (time_offset_s of metrics.json) and "
      "gives "
      "poses on the IMU's clock{}",
      offset_s, explains ? ": this truth is on the LiDAR's" : "; it is not that alone");
}

/// What the covariances of a frame are relative to.
struct Gauges {
  eval::Gauge trajectory, live;
};

Gauges gauges_of(const std::vector<Judged>& group, eval::Alignment asked) {
  std::vector<StatedPairs> trajectory, live;
  for (const Judged& v : group) {
    trajectory.push_back({&v.pairs, &v.input->trajectory.covariances, v.is_reference});
    live.push_back({&v.live_pairs, &v.input->live.covariances, v.is_reference});
  }
  return {frame_gauge(trajectory, asked), frame_gauge(live, asked)};
}

/// Evaluates vehicles in one frame.
class FrameJudge {
 public:
  FrameJudge(const EvaluationOptions& options, Evaluation& result)
      : options_(options), result_(result) {}

  Status add(const std::vector<Judged>& group, const Gauges& gauges) {
    eval::PairList all;
    for (const Judged& v : group) all.insert(all.end(), v.pairs.begin(), v.pairs.end());
    const Result<FrameFit> fit = fit_frame(all, options_.align);
    if (!fit) return tl::make_unexpected(fit.error());
    FrameScore frame{{}, fit->T_truth_est, fit->used};
    for (const Judged& v : group) frame.vehicles.push_back(v.input->name);
    if (!fit->why.empty()) {
      result_.warnings.push_back(fmt::format("{}: {}", fmt::join(frame.vehicles, ", "), fit->why));
    }
    for (const Judged& v : group) {
      if (Status s = add_vehicle(v, fit->T_truth_est, gauges.trajectory); !s) return s;
    }
    result_.frames.push_back(std::move(frame));
    return add_live(group, gauges.live);
  }

  void finish() {
    result_.fleet = score_of(fleet_, options_.distances_m);
    if (!fleet_live_.rows.empty()) {
      result_.fleet_live = score_of(fleet_live_, options_.distances_m);
    }
    if (!fleet_odometry_.rows.empty()) {
      result_.fleet_odometry = score_of(fleet_odometry_, options_.distances_m);
    }
  }

 private:
  Status add_vehicle(const Judged& v, const SE3& T_truth_est, const eval::Gauge& gauge) {
    const SampleOptions how{options_.distances_m, options_.all_pairs, T_truth_est, gauge};
    const Samples samples = samples_of(v.pairs, v.input->trajectory.covariances,
                                       v.input->degenerate_map, v.input->truth, how);
    VehicleScore score;
    score.name = v.input->name;
    score.trajectory = score_of(samples, options_.distances_m);
    score.trajectory.drift = eval::drift(v.pairs, T_truth_est);
    if (!is_level(*v.input)) score.trajectory.drift->z_m.reset();
    if (const Result<FrameFit> alone = fit_frame(v.pairs, options_.align); alone) {
      score.trajectory.alone_rmse_m =
          eval::translation_statistics(eval::absolute_errors(v.pairs, alone->T_truth_est)).rmse;
    }
    warn_of_shift(v, T_truth_est);
    score.rows = samples.rows;
    fleet_.append(samples);
    if (!v.odometry_pairs.empty()) {
      if (Status s = add_odometry(v, score); !s) return s;
    }
    result_.vehicles.push_back(std::move(score));
    return {};
  }

  /// A tilt of 1 degree is an error of 0.17 m in height after 10 m: only a frame levelled by
  /// gravity shows a drift in height. Alignment by yaw or without alignment asserts that both
  /// frames are level.
  [[nodiscard]] bool is_level(const VehicleInput& vehicle) const {
    const bool asserted =
        options_.align == eval::Alignment::kYaw || options_.align == eval::Alignment::kNone;
    return vehicle.levelled.value_or(asserted);
  }

  /// A clock offset looks like a position error, so it is reported.
  void warn_of_shift(const Judged& v, const SE3& T_truth_est) {
    const auto shift = eval::time_shift(v.pairs, T_truth_est);
    if (!shift || std::abs(shift->shift_s) < kShiftMin_s) return;
    if (shift->rmse_after_m > kShiftFraction * shift->rmse_m) return;
    result_.warnings.push_back(fmt::format(
        "{}: stamps {:.3f} s {} than they are would explain most of the error (position rmse "
        "{:.4f} -> {:.4f} m); {}",
        v.input->name, std::abs(shift->shift_s), shift->shift_s > 0.0 ? "later" : "earlier",
        shift->rmse_m, shift->rmse_after_m, cause_of_shift(shift->shift_s, *v.input)));
  }

  /// Live poses are in map, too, but at their time its alignment was less accurate. They are
  /// aligned separately, with one transform for all. The vehicles of the group are the last in the
  /// result.
  Status add_live(const std::vector<Judged>& group, const eval::Gauge& gauge) {
    eval::PairList all;
    for (const Judged& v : group) {
      all.insert(all.end(), v.live_pairs.begin(), v.live_pairs.end());
    }
    if (all.empty()) return {};
    const Result<FrameFit> fit = fit_frame(all, options_.align);
    if (!fit) return tl::make_unexpected(fit.error());
    const SampleOptions how{options_.distances_m, options_.all_pairs, fit->T_truth_est, gauge};
    const std::size_t first = result_.vehicles.size() - group.size();
    for (std::size_t i = 0; i < group.size(); ++i) {
      const Judged& v = group[i];
      if (v.live_pairs.empty()) continue;
      // Degenerate directions are known for the final poses only.
      const Samples samples =
          samples_of(v.live_pairs, v.input->live.covariances, {}, v.input->truth, how);
      TrackScore& score = result_.vehicles[first + i].live.emplace();
      score = score_of(samples, options_.distances_m);
      score.drift = eval::drift(v.live_pairs, fit->T_truth_est);
      if (!is_level(*v.input)) score.drift->z_m.reset();
      fleet_live_.append(samples);
    }
    return {};
  }

  /// Each odometry has its own frame, so it is aligned separately.
  Status add_odometry(const Judged& v, VehicleScore& score) {
    const Result<FrameFit> fit = fit_frame(v.odometry_pairs, options_.align);
    if (!fit) return tl::make_unexpected(fit.error());
    const StatedPairs stated{&v.odometry_pairs, &v.input->odometry.covariances, true};
    const SampleOptions how{options_.distances_m, options_.all_pairs, fit->T_truth_est,
                            frame_gauge({&stated, 1}, options_.align)};
    // Degenerate directions are known in map only, not in the frame of the odometry.
    const Samples samples =
        samples_of(v.odometry_pairs, v.input->odometry.covariances, {}, v.input->truth, how);
    score.odometry = score_of(samples, options_.distances_m);
    score.odometry->drift = eval::drift(v.odometry_pairs, fit->T_truth_est);
    score.odometry->drift->z_m.reset();  // its first pose is level only roughly
    fleet_odometry_.append(samples);
    return {};
  }

  const EvaluationOptions& options_;
  Evaluation& result_;
  Samples fleet_, fleet_live_, fleet_odometry_;
};

void add_between(const std::vector<Judged>& group, Evaluation& result) {
  for (std::size_t i = 0; i < group.size(); ++i) {
    for (std::size_t j = i + 1; j < group.size(); ++j) {
      const auto errors = eval::errors_between(group[i].pairs, group[j].pairs, kBetweenGap_s);
      if (errors.empty()) continue;
      result.between.push_back({group[i].input->name, group[j].input->name,
                                eval::translation_statistics(errors),
                                eval::rotation_statistics(errors)});
    }
  }
}

}  // namespace

std::string Evaluation::how() const {
  const std::string_view name = eval::kAlignmentNames[static_cast<std::size_t>(options.align)];
  std::string text = fmt::format("alignment {}", name);
  if (options.align != eval::Alignment::kNone) {
    const bool several = vehicles.size() > 1;
    if (options.each && several) text += ", one per vehicle";
    if (!options.each && several && frames.size() > 1) {
      text += fmt::format(", one for each of {} frames", frames.size());
    }
    if (!options.each && several && frames.size() == 1) text += ", one for the fleet";
  }
  if (options.associate.mode == eval::AssociationMode::kInterpolate) {
    return text + fmt::format("; truth interpolated, gaps above {} s left out",
                              options.associate.max_gap_s);
  }
  return text + fmt::format("; nearest stamps within {} s", options.associate.max_dt_s);
}

Result<Evaluation> evaluate_tracks(const RunInput& run, const EvaluationOptions& options) {
  Evaluation result;
  result.input = run.name;
  result.options = options;
  result.warnings = run.warnings;
  FrameJudge judge(options, result);
  for (const std::vector<std::size_t>& group : run.groups) {
    std::vector<Judged> vehicles;
    for (const std::size_t i : group) {
      if (run.vehicles[i].truth.empty()) continue;
      Result<Judged> vehicle = judged(run.vehicles[i], options);
      if (!vehicle) return tl::make_unexpected(vehicle.error());
      vehicle->is_reference = i == group.front();
      vehicles.push_back(std::move(*vehicle));
      warn_of_slow_truth(run.vehicles[i], options, result.warnings);
    }
    if (vehicles.empty()) continue;
    add_between(vehicles, result);
    // Whatever the alignment, the covariances are relative to the frame's reference.
    const Gauges gauges = gauges_of(vehicles, options.align);
    if (!options.each) {
      if (Status s = judge.add(vehicles, gauges); !s) return tl::make_unexpected(s.error());
      continue;
    }
    for (Judged& vehicle : vehicles) {
      std::vector<Judged> one;
      one.push_back(std::move(vehicle));
      if (Status s = judge.add(one, gauges); !s) return tl::make_unexpected(s.error());
    }
  }
  judge.finish();
  return result;
}

Status evaluate_cloud(const std::string& file, const eval::PointList& points,
                      const eval::TriangleMesh* mesh, const SE3& T_mesh_cloud, Executor& executor,
                      Evaluation& result) {
  CloudScore score;
  score.file = file;
  score.points = points.size();
  score.shape = eval::map_shape(points, {}, executor);
  if (mesh != nullptr) {
    const eval::TriangleTree tree(*mesh);
    SE3 T = T_mesh_cloud;
    if (result.options.mesh_icp) {
      score.before_icp = eval::cloud_to_mesh(points, T, *mesh, tree, {}, executor);
      const eval::PointList thin = eval::thinned(points, eval::CloudToMeshOptions{}.thin_m);
      const Result<eval::MeshIcp> icp = eval::align_to_mesh(thin, T, tree, {}, executor);
      if (!icp) {
        Error error = icp.error();
        error.where = file;
        return tl::make_unexpected(std::move(error));
      }
      score.icp = *icp;
      T = icp->T_mesh_cloud;
    }
    score.to_mesh = eval::cloud_to_mesh(points, T, *mesh, tree, {}, executor);
  }
  result.cloud = std::move(score);
  return {};
}

Result<eval::PointList> read_points(const std::string& path) {
  const Result<io::CloudFile> cloud = io::read_cloud_file(path);
  if (!cloud) return tl::make_unexpected(cloud.error());
  std::array<std::vector<double>, 3> columns;
  for (std::size_t i = 0; const char* name : {"x", "y", "z"}) {
    const int field = cloud->field(name);
    if (field < 0) return fail(ErrorCode::kInput, path, fmt::format("has no field '{}'", name));
    columns[i++] = cloud->column(field);
  }
  eval::PointList points(cloud->size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = geometry::Vec3(columns[0][i], columns[1][i], columns[2][i]);
  }
  if (points.empty()) return fail(ErrorCode::kInput, path, "has no points");
  return points;
}

}  // namespace rali::assess
