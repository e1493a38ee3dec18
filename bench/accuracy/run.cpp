#include "run.hpp"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "common/cpu_time.hpp"
#include "common/vehicle_settings.hpp"
#include "rali/eval/alignment.hpp"
#include "rali/eval/consistency.hpp"
#include "rali/eval/errors.hpp"
#include "rali/vehicle/odom_frame.hpp"
#include "rali/vehicle/vehicle.hpp"
#include "recording.hpp"

namespace rali::accuracy {

using geometry::SE3;
using geometry::Vec3;

namespace {

/// Largest resident memory since the last reset [MB]; Linux only, 0 elsewhere.
double peak_memory_mb() {
  std::FILE* file = std::fopen("/proc/self/status", "r");
  if (file == nullptr) return 0.0;
  char line[256];
  long kb = 0;
  while (std::fgets(line, sizeof line, file) != nullptr) {
    if (std::sscanf(line, "VmHWM: %ld kB", &kb) == 1) break;
  }
  std::fclose(file);
  return static_cast<double>(kb) / 1024.0;
}

void reset_peak_memory() {
  if (std::FILE* file = std::fopen("/proc/self/clear_refs", "w")) {
    std::fputs("5", file);
    std::fclose(file);
  }
}

Result<vehicle::VehicleSettings> settings_of(const RunOptions& options, const RecordingHead& head,
                                             bool has_imu) {
  std::vector<std::string> assignments = options.settings;
  assignments.insert(assignments.begin(), "odometry.preset=" + options.preset);
  auto settings = bench::vehicle_settings(assignments);
  if (!settings) return settings;
  settings->calibration = head.calibration;
  settings->has_imu = has_imu;
  return settings;
}

/// Feeds the vehicle and collects its poses with their CPU time.
class Driver {
 public:
  void start(const vehicle::VehicleSettings& settings) { vehicle_.emplace(VehicleId{1}, settings); }

  void step(const vehicle::Event& event) {
    const double begin = bench::cpu_ms();
    vehicle_->step(event, executor_, out_);
    spent_ms_ += bench::cpu_ms() - begin;
    for (vehicle::Output& output : out_) {
      if (auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) {
        rows_.push_back({std::move(*pose), {}, spent_ms_});
        spent_ms_ = 0.0;
      } else if (std::holds_alternative<Finding>(output)) {
        ++findings_;
      }
    }
    out_.clear();
  }

  void add_truth(const eval::StampedPose& truth) { truth_.push_back(truth); }

  [[nodiscard]] const eval::PoseList& truth() const { return truth_; }

  [[nodiscard]] std::vector<ScanRow>& rows() { return rows_; }

  [[nodiscard]] std::size_t findings() const { return findings_; }

 private:
  std::optional<vehicle::Vehicle> vehicle_;
  SerialExecutor executor_;
  vehicle::OutputList out_;
  std::vector<ScanRow> rows_;
  eval::PoseList truth_;
  double spent_ms_ = 0.0;
  std::size_t findings_ = 0;
};

double rmse(const std::vector<double>& values) { return eval::statistics(values).rmse; }

void score_trajectory(const eval::PairList& pairs, Scores& s) {
  // On straight routes the roll about the line is unobservable; then only the start is aligned.
  auto T = eval::align(pairs, eval::Alignment::kSe3);
  if (!T) T = eval::align(pairs, eval::Alignment::kOrigin);
  const eval::Statistics ape = eval::translation_statistics(eval::absolute_errors(pairs, *T));
  s.ape_rmse_m = ape.rmse;
  s.ape_max_m = ape.max;
  s.z_rmse_m = rmse(eval::axis_errors(pairs, *T, Vec3::UnitZ()));
  s.slip_rmse_m = rmse(eval::along_path_errors(pairs, *T, 2.0));
  const auto relative = eval::relative_errors(pairs, {10.0, true, 0.1});
  s.rpe10_m = eval::translation_statistics(relative).rmse;
  s.rpe10_deg = eval::rotation_statistics(relative).rmse * 180.0 / std::numbers::pi;
  const auto T_origin = eval::align(pairs, eval::Alignment::kOrigin);
  s.end_m = eval::absolute_errors(pairs, *T_origin).back().translation_m;
}

geometry::Mat6 odom_covariance(const vehicle::PoseEstimate& pose) {
  return vehicle::odom_covariance(pose.covariance, pose.T_local_body, pose.T_odom_body);
}

/// Uses the frame of the first pose, as a user of odometry/<v> gets it.
void score_consistency(const eval::PairList& pairs, const std::vector<ScanRow>& rows, Scores& s) {
  std::vector<geometry::Mat6> covariances;
  for (const ScanRow& row : rows) covariances.push_back(odom_covariance(row.pose));
  const SE3 T_est_ref = pairs.front().est * pairs.front().ref.inverse();
  const eval::Consistency six = eval::consistency(pairs, covariances, T_est_ref, 6);
  s.nees6 = six.mean;
  s.fraction95 = six.fraction_within_95;
  s.nees3 = eval::consistency(pairs, covariances, T_est_ref, 3).mean;
}

void score_effort(const std::vector<ScanRow>& rows, Scores& s) {
  std::vector<double> cpu;
  for (const ScanRow& row : rows) {
    cpu.push_back(row.cpu_ms);
    s.weak += row.pose.quality == vehicle::PoseQuality::kWeak ||
                      row.pose.quality == vehicle::PoseQuality::kPredicted
                  ? 1
                  : 0;
    s.diverged += row.pose.quality == vehicle::PoseQuality::kDiverged ? 1 : 0;
  }
  s.cpu_ms = eval::statistics(cpu).mean;
  s.cpu_p99_ms = eval::quantile(cpu, 0.99);
}

void write_tum(const std::string& path, const eval::PoseList& poses) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) return;
  for (const eval::StampedPose& p : poses) {
    const Eigen::Quaterniond q(p.T.R);
    fmt::print(file, "{}.{:09d} {:.6f} {:.6f} {:.6f} {:.8f} {:.8f} {:.8f} {:.8f}\n",
               p.t.ns / 1'000'000'000, p.t.ns % 1'000'000'000, p.T.p.x(), p.T.p.y(), p.T.p.z(),
               q.x(), q.y(), q.z(), q.w());
  }
  std::fclose(file);
}

/// Errors per scan with the first poses aligned: position and direction of the errors.
void write_scans(const std::string& path, const eval::PairList& pairs,
                 const std::vector<ScanRow>& rows) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) return;
  const SE3 T_ref_est = pairs.front().ref * pairs.front().est.inverse();
  fmt::print(file,
             "t_s,error_m,error_deg,ahead_m,left_m,up_m,roll_deg,pitch_deg,yaw_deg,sd_x_m,sd_y_m,"
             "sd_z_m,nees6,nees3,quality,matches,residual_m,cpu_ms\n");
  for (const eval::PosePair& p : pairs) {
    const ScanRow& row = rows[p.est_index];
    const SE3 E = p.ref.inverse() * (T_ref_est * p.est);
    const Vec3 turn = geometry::so3_log(E.R) * 180.0 / std::numbers::pi;
    const SE3 truth = T_ref_est.inverse() * p.ref;
    const geometry::Mat6 P = odom_covariance(row.pose);
    fmt::print(file,
               "{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.5f},{:.5f},"
               "{:.5f},{:.2f},{:.2f},{},{},{:.4f},{:.2f}\n",
               seconds_between(pairs.front().t, p.t), E.p.norm(), turn.norm(), E.p.x(), E.p.y(),
               E.p.z(), turn.x(), turn.y(), turn.z(), std::sqrt(P(3, 3)), std::sqrt(P(4, 4)),
               std::sqrt(P(5, 5)), eval::nees_pose(p.est, truth, P).value_or(-1.0),
               eval::nees_position(p.est, truth, P).value_or(-1.0),
               static_cast<int>(row.pose.quality), row.pose.matches, row.pose.residual_rms_m,
               row.cpu_ms);
  }
  std::fclose(file);
}

void dump(const std::string& dir, const Scores& s, const eval::PoseList& est,
          const eval::PoseList& truth, const eval::PairList& pairs,
          const std::vector<ScanRow>& rows) {
  std::error_code ignored;
  std::filesystem::create_directories(dir, ignored);
  const std::string stem = fmt::format("{}/{}_{}_{}", dir, s.scene, s.seed, s.preset);
  write_tum(stem + "_estimate.tum", est);
  write_tum(stem + "_truth.tum", truth);
  write_scans(stem + "_sweeps.csv", pairs, rows);
}

}  // namespace

Result<Scores> run(const sim::SimOptions& sim, const RunOptions& options) {
  reset_peak_memory();
  Driver driver;
  Scores s;
  s.scene = sim::kSceneNames[static_cast<std::size_t>(sim.scene)];
  s.seed = sim.seed;
  s.preset = options.preset;
  // Settings are checked before a long recording is simulated.
  if (auto checked = settings_of(options, {}, sim.with_imu); !checked) {
    return tl::make_unexpected(checked.error());
  }
  Listener listener;
  listener.on_head = [&](const RecordingHead& head) {
    s.path_m = head.path_m;
    driver.start(settings_of(options, head, sim.with_imu).value());
  };
  listener.on_imu = [&](const sensor::ImuSample& imu) { driver.step(imu); };
  listener.on_scan = [&](std::shared_ptr<const sensor::LidarScan> scan,
                         const eval::StampedPose& truth) {
    ++s.scans;
    driver.add_truth(truth);
    driver.step(std::move(scan));
  };
  if (auto ok = play(sim, options.cache_dir, listener); !ok) return tl::make_unexpected(ok.error());
  driver.step(vehicle::EndOfData{});
  s.peak_mb = peak_memory_mb();

  std::vector<ScanRow>& rows = driver.rows();
  eval::PoseList est;
  for (const ScanRow& row : rows) est.push_back({row.pose.t, row.pose.T_odom_body});
  const auto matched =
      eval::associate(est, driver.truth(), {eval::AssociationMode::kNearest, 0.001, 0.0});
  if (!matched) return tl::make_unexpected(matched.error());
  s.poses = matched->pairs.size();
  s.findings = driver.findings();
  score_trajectory(matched->pairs, s);
  score_consistency(matched->pairs, rows, s);
  score_effort(rows, s);
  if (!options.dump_dir.empty()) {
    dump(options.dump_dir, s, est, driver.truth(), matched->pairs, rows);
  }
  return s;
}

}  // namespace rali::accuracy
