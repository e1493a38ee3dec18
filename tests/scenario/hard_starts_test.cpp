// Seeds of starts that failed in the past: the first seconds have few LiDAR features. Whole
// vehicle.
#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "rali/base/executor.hpp"
#include "rali/sim/simulation.hpp"
#include "rali/vehicle/odom_frame.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali {
namespace {

struct Start {
  sim::Scene scene = sim::Scene::kLoop;
  std::uint64_t seed = 1;
  double rest_s = 3.0;
  int pedestrians = 6;
};

struct Outcome {
  bool diverged = false;
  double farthest_m = 0.0;  ///< from the start, while the true vehicle was at standstill
  double speed_max_mps = 0.0;
  double end_sigma_m = 0.0;
  double end_error_m = 0.0;  ///< of the path from the first pose, against ground truth
  double silent_m = 0.0;     ///< largest error beyond four sigma, from 2 s on
};

Outcome drive(const Start& start, double duration_s) {
  sim::SimOptions options;
  options.scene = start.scene;
  options.seed = start.seed;
  options.pedestrians = start.pedestrians;
  options.motion.standstill_s = start.rest_s;
  options.duration_s = duration_s;
  auto simulation = sim::make_simulation(options);
  EXPECT_TRUE(simulation);
  vehicle::VehicleSettings settings;
  settings.has_imu = true;
  settings.calibration = (*simulation)->calibration_nominal();
  vehicle::Vehicle vehicle(VehicleId{0}, settings);
  SerialExecutor executor;
  Outcome out;
  vehicle::OutputList outputs;
  geometry::Vec3 first_true = geometry::Vec3::Zero();
  geometry::Vec3 first = geometry::Vec3::Zero();
  Time t_first;
  int poses = 0;
  while (const auto message = (*simulation)->next()) {
    outputs.clear();
    std::visit([&](const auto& data) { vehicle.step(data, executor, outputs); }, *message);
    for (const vehicle::Output& output : outputs) {
      if (const auto* f = std::get_if<Finding>(&output)) {
        out.diverged = out.diverged || f->id == "odometry.diverged";
      }
      const auto* pose = std::get_if<vehicle::PoseEstimate>(&output);
      if (pose == nullptr) continue;
      const geometry::Vec3 p_true = (*simulation)->truth(pose->t).state.T_world_body.p;
      if (poses++ == 0) {
        first = pose->T_odom_body.p;
        first_true = p_true;
        t_first = pose->t;
      }
      const double path_m = (pose->T_odom_body.p - first).norm();
      const double true_m = (p_true - first_true).norm();
      if (true_m < 0.005) out.farthest_m = std::max(out.farthest_m, path_m);
      out.speed_max_mps = std::max(out.speed_max_mps, pose->v_odom_mps.norm());
      out.end_error_m = std::abs(path_m - true_m);
      const geometry::Mat6 P =
          vehicle::odom_covariance(pose->covariance, pose->T_local_body, pose->T_odom_body);
      out.end_sigma_m = std::sqrt(P.bottomRightCorner<3, 3>().trace());
      if (seconds_between(t_first, pose->t) > 2.0 && out.end_error_m > 4.0 * out.end_sigma_m) {
        out.silent_m = std::max(out.silent_m, out.end_error_m);
      }
    }
  }
  EXPECT_GT(poses, 10);
  return out;
}

TEST(HardStarts, a_standing_vehicle_does_not_drift_along_a_degenerate_corridor) {
  // Sixteen rings, a map one scan old, people walking by: no other structure along the axis.
  for (const std::uint64_t seed : {4, 5, 26}) {
    const Outcome out = drive({sim::Scene::kLoop, seed}, 6.0);
    EXPECT_FALSE(out.diverged) << seed;
    EXPECT_LT(out.farthest_m, 0.05) << seed;
    EXPECT_LT(out.end_error_m, 0.05) << seed;
  }
}

TEST(HardStarts, a_start_in_motion_in_a_degenerate_corridor_does_not_diverge) {
  // The speed is unobservable by the LiDAR here and is reported so. Weak coupling with pitch must
  // not drag the estimate along.
  for (const std::uint64_t seed : {31, 52}) {
    const Outcome out = drive({sim::Scene::kLoop, seed, 0.0, 4}, 12.0);
    EXPECT_FALSE(out.diverged) << seed;
    EXPECT_LT(out.speed_max_mps, 5.0) << seed;
  }
}

TEST(HardStarts, walls_with_few_points_constrain_a_start_in_motion) {
  // A tenth of a scan faces the weakest direction. That was refused, because the map of a start in
  // motion counted as young, and the vehicle drifted by metres on an uncalibrated inertial sensor.
  // In the last start gravity is wrong at first. Walls on all sides contradict it and were refused
  // for that.
  using sim::Scene;
  const std::vector<Start> starts = {{Scene::kHall, 1, 0.0, 0},    {Scene::kHall, 2, 0.0, 0},
                                     {Scene::kGarage, 1, 0.0, 0},  {Scene::kGarage, 2, 0.0, 0},
                                     {Scene::kMine, 1, 0.0, 0},    {Scene::kMine, 2, 0.0, 0},
                                     {Scene::kGarage, 135, 0.0, 4}};
  for (const Start& start : starts) {
    const Outcome out = drive(start, 12.0);
    EXPECT_FALSE(out.diverged) << start.seed;
    EXPECT_LT(out.end_error_m, 0.1) << static_cast<int>(start.scene) << ' ' << start.seed;
  }
}

TEST(HardStarts, floor_rings_moving_with_the_vehicle_do_not_bias_the_initial_velocity) {
  // Registration of the first scans alone gives a vehicle at standstill. Odometry recovers the
  // resulting error by 3 cm per scan, so the error is checked later.
  const std::vector<Start> starts = {{sim::Scene::kLoop, 4, 0.0, 0},
                                     {sim::Scene::kLoop, 10, 0.0, 0},
                                     {sim::Scene::kFloor, 82, 0.0, 4}};
  for (const Start& start : starts) {
    const Outcome out = drive(start, 42.0);
    EXPECT_FALSE(out.diverged) << start.seed;
    EXPECT_LT(out.end_error_m, 0.4) << start.seed;  // 7 m if only the first speed is used
  }
}

TEST(HardStarts, people_and_an_open_yard_do_not_bias_the_initial_velocity) {
  // Few surfaces face the motion, and the ground does not constrain it. At a wrong first speed more
  // points match the ground, since its rings fill ever new cells. With ground points counted,
  // errors reached 30 m after 12 s with sigmas of centimetres.
  const std::vector<Start> starts = {
      {sim::Scene::kYard, 83, 0.0, 12},  {sim::Scene::kYard, 85, 0.0, 12},
      {sim::Scene::kYard, 88, 0.0, 12},  {sim::Scene::kYard, 95, 0.0, 12},
      {sim::Scene::kYard, 91, 0.0, 12},  {sim::Scene::kYard, 101, 0.0, 12},
      {sim::Scene::kGarage, 82, 0.0, 4}, {sim::Scene::kLoop, 87, 0.0, 12}};
  for (const Start& start : starts) {
    const Outcome out = drive(start, 12.0);
    EXPECT_FALSE(out.diverged) << start.seed;
    EXPECT_LT(out.end_error_m, 0.1) << start.seed;
    EXPECT_LT(out.silent_m, 0.3) << start.seed;
  }
}

TEST(HardStarts, imu_calibration_at_standstill_keeps_tunnel_drift_within_3_sigma) {
  // The first poses of a young map vary by milliradians. Gravity from the last of them applied to
  // the first one gave an error of 30 m within a minute with a sigma of 4 m.
  std::vector<double> errors_m;
  for (const std::uint64_t seed : {14, 15, 16}) {
    Start start{sim::Scene::kTunnel, seed, 6.0, 0};
    const Outcome out = drive(start, 45.0);
    EXPECT_LT(out.end_error_m, 3.0 * out.end_sigma_m) << seed;
    errors_m.push_back(out.end_error_m);
  }
  std::sort(errors_m.begin(), errors_m.end());
  EXPECT_LT(errors_m[1], 6.0) << "what 3 mrad/sqrt(s) of such a gyro come to in 39 s, and no more";
}

}  // namespace
}  // namespace rali
