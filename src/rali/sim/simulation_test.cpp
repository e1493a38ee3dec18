#include "rali/sim/simulation.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace rali::sim {
namespace {

using geometry::SE3;
using geometry::Vec3;

SimOptions quiet(Scene scene) {
  SimOptions o;
  o.scene = scene;
  o.imu = ImuOptions::ideal();
  o.ranging.noise_m = 0.0;
  o.ranging.resolution_m = 0.001;
  o.ranging.max_range_m = 60.0;
  o.ranging.dropouts = false;
  o.ranging.mixed_fraction = 0.0;
  return o;
}

std::unique_ptr<Simulation> make(const SimOptions& o) {
  auto sim = make_simulation(o);
  EXPECT_TRUE(sim.has_value());
  return std::move(*sim);
}

std::shared_ptr<const sensor::LidarScan> scan_number(Simulation& sim, int number) {
  while (auto message = sim.next()) {
    if (auto* scan = std::get_if<std::shared_ptr<const sensor::LidarScan>>(&*message)) {
      if (number-- == 0) return *scan;
    }
  }
  return nullptr;
}

TEST(Simulation, noise_free_inertial_samples_integrate_back_to_the_trajectory) {
  SimOptions o = quiet(Scene::kCorridor);
  o.duration_s = 20.0;
  o.imu_apart = true;
  const auto sim = make(o);
  const SE3 T_body_imu = sim->calibration_true().T_body_imu;
  std::vector<sensor::ImuSample> samples;
  while (auto message = sim->next()) {
    if (auto* imu = std::get_if<sensor::ImuSample>(&*message)) samples.push_back(*imu);
  }
  ASSERT_EQ(samples.size(), 4001U);
  const std::size_t first = 1600;  // t = 8 s, driving
  const Truth start = sim->truth(samples[first].t);
  EXPECT_GT(start.state.v_world_mps.norm(), 0.5);
  SE3 T = start.state.T_world_body * T_body_imu;
  Vec3 v = start.state.v_world_mps +
           start.state.T_world_body.R * start.state.omega_body_radps.cross(T_body_imu.p);
  const Vec3 g(0.0, 0.0, -kGravity_mps2);
  for (std::size_t i = first; i + 1 < samples.size() && i < first + 2000; ++i) {
    const double dt = seconds_between(samples[i].t, samples[i + 1].t);
    const Vec3 rate = 0.5 * (samples[i].gyro_radps + samples[i + 1].gyro_radps);
    const geometry::Mat3 R_next = T.R * geometry::so3_exp(rate * dt);
    const Vec3 a = 0.5 * (T.R * samples[i].accel_mps2 + R_next * samples[i + 1].accel_mps2) + g;
    T = {R_next, T.p + v * dt + 0.5 * dt * dt * a};
    v += a * dt;
  }
  const Truth end = sim->truth(samples[first + 2000].t);
  const SE3 T_imu_true = end.state.T_world_body * T_body_imu;
  EXPECT_LT((T.p - T_imu_true.p).norm(), 0.01);
  EXPECT_LT(geometry::so3_log(T.R.transpose() * T_imu_true.R).norm(), 1e-3);
}

TEST(Simulation, points_deskewed_with_ground_truth_lie_on_the_walls) {
  const auto sim = make(quiet(Scene::kCorridor));
  const auto scan = scan_number(*sim, 60);
  ASSERT_NE(scan, nullptr);
  ASSERT_GT(scan->size(), 20000U);
  double moved = 0.0;
  for (std::size_t i = 0; i < scan->size(); i += 97) {
    const Time t = scan->t_start + Duration::from_s(static_cast<double>(scan->dt_s[i]));
    const SE3 T = sim->truth(t).state.T_world_body * sim->calibration_true().T_body_lidar;
    const Vec3 point(static_cast<double>(scan->x_m[i]), static_cast<double>(scan->y_m[i]),
                     static_cast<double>(scan->z_m[i]));
    EXPECT_LT(sim->ray_caster().distance_to_surface(T * point, 1.0), 7e-4);
    const SE3 T_start =
        sim->truth(scan->t_start).state.T_world_body * sim->calibration_true().T_body_lidar;
    moved = std::max(moved, (T * point - T_start * point).norm());
  }
  // Otherwise the test would also pass with one pose for the whole scan.
  EXPECT_GT(moved, 0.05);
}

TEST(Simulation, same_seed_gives_identical_scans_and_another_seed_does_not) {
  SimOptions o;
  o.scene = Scene::kLoop;
  o.pedestrians = 4;
  const auto first = scan_number(*make(o), 5);
  const auto again = scan_number(*make(o), 5);
  o.seed = 2;
  const auto other = scan_number(*make(o), 5);
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->x_m, again->x_m);
  EXPECT_EQ(first->dt_s, again->dt_s);
  EXPECT_NE(first->x_m, other->x_m);
}

TEST(Simulation, messages_come_in_order_of_arrival) {
  SimOptions o;
  o.duration_s = 0.5;
  const auto sim = make(o);
  Time last = sim->t_start();
  int scans = 0;
  int samples = 0;
  while (auto message = sim->next()) {
    if (auto* imu = std::get_if<sensor::ImuSample>(&*message)) {
      EXPECT_GE(imu->t, last);
      last = imu->t;
      ++samples;
    } else {
      const auto& scan = std::get<std::shared_ptr<const sensor::LidarScan>>(*message);
      EXPECT_LE(scan->t_end - last, Duration::from_s(0.005));
      EXPECT_GE(scan->t_end, last);
      ++scans;
    }
  }
  EXPECT_EQ(scans, 5);
  EXPECT_EQ(samples, 101);
}

TEST(Simulation, nominal_calibration_differs_by_the_set_errors) {
  SimOptions o;
  const auto sim = make(o);
  const SE3 error =
      sim->calibration_true().T_body_lidar.inverse() * sim->calibration_nominal().T_body_lidar;
  EXPECT_NEAR(error.p.norm(), 0.002, 1e-9);
  EXPECT_NEAR(geometry::so3_log(error.R).norm() * 180.0 / M_PI, 0.05, 1e-6);
}

TEST(Simulation, options_outside_their_range_are_refused_by_name) {
  SimOptions o;
  o.motion.speed_factor = std::nan("");
  const auto sim = make_simulation(o);
  ASSERT_FALSE(sim.has_value());
  EXPECT_EQ(sim.error().code, ErrorCode::kUsage);
  EXPECT_NE(sim.error().message().find("speed_factor"), std::string::npos);
}

}  // namespace
}  // namespace rali::sim
