// Properties of any recording of the simulator, checked on recordings with all errors on.
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "rali/sim/fleet/fleet_simulation.hpp"
#include "rali/sim/internal/test_fleet.hpp"

namespace rali::sim {
namespace {

using geometry::SE3;
using geometry::Vec3;

std::unique_ptr<FleetSimulation> recording(Scene scene, int vehicles, const FleetOptions& o) {
  auto sim = make_fleet_simulation(world_for(make_world(scene, 2), vehicles).value(), o);
  EXPECT_TRUE(sim.has_value());
  return std::move(*sim);
}

/// Distances to the mesh of some points of the scans from 2.7 s on, without points on the other
/// vehicle. Each point is transformed by the true pose of its own instant.
std::vector<double> distances_to_mesh(FleetSimulation& sim) {
  std::vector<double> out;
  std::size_t skip = 0;
  while (const auto m = sim.next()) {
    const auto* scan = std::get_if<std::shared_ptr<const sensor::LidarScan>>(&m->data);
    if (scan == nullptr || seconds_between(sim.t_start(), (*scan)->t_start) < 2.7) continue;
    const sensor::LidarScan& s = **scan;
    for (std::size_t i = skip; i < s.size(); i += 1499) {
      const Time t = s.t_start + Duration::from_s(static_cast<double>(s.dt_s[i]));
      const SE3 T = sim.truth(m->vehicle, t).state.T_world_body *
                    sim.calibration_true(m->vehicle).T_body_lidar;
      const Vec3 p = T * Vec3(static_cast<double>(s.x_m[i]), static_cast<double>(s.y_m[i]),
                              static_cast<double>(s.z_m[i]));
      const Vec3 other = sim.truth(1 - m->vehicle, t).state.T_world_body.p;
      if ((p - other).norm() > 0.8) out.push_back(sim.ray_caster().distance_to_surface(p, 0.2));
    }
    skip += 7;
  }
  return out;
}

TEST(Physics, scans_at_ground_truth_poses_lie_on_the_mesh_within_range_noise) {
  for (const Scene scene : {Scene::kCorridor, Scene::kMine}) {
    FleetOptions o;
    o.vehicles = 2;
    o.vehicle.duration_s = 3.5;
    o.vehicle.motion.standstill_s = 0.5;
    o.vehicle.ranging.mixed_fraction = 0.0;
    const std::vector<double> d = distances_to_mesh(*recording(scene, 2, o));
    ASSERT_GT(d.size(), 180U);
    double squares = 0.0;
    for (const double x : d) {
      squares += x * x;
      EXPECT_LT(x, 4.5 * o.vehicle.ranging.noise_m);
    }
    // Oblique rays move along the surface: the spread is below that of the range, but not far
    // below.
    const double rms = std::sqrt(squares / static_cast<double>(d.size()));
    EXPECT_LT(rms, o.vehicle.ranging.noise_m);
    EXPECT_GT(rms, 0.25 * o.vehicle.ranging.noise_m);
  }
}

TEST(Physics, noise_free_inertial_samples_of_every_vehicle_integrate_to_its_trajectory) {
  FleetOptions o = internal::quiet_fleet(2);
  o.vehicle.with_lidar = false;
  o.vehicle.imu_apart = true;
  o.ranges = o.radio_link = false;
  o.vehicle.motion.standstill_s = 0.5;
  const auto sim = recording(Scene::kCorridor, 2, o);
  std::vector<sensor::ImuSample> samples[2];
  while (const auto m = sim->next()) {
    samples[m->vehicle].push_back(std::get<sensor::ImuSample>(m->data));
  }
  for (int v = 0; v < 2; ++v) {
    const SE3 mount = sim->calibration_true(v).T_body_imu;
    const auto& s = samples[v];
    for (std::size_t first = 0; first + 2000 < s.size(); first += 2000) {  // 10 s each
      const MotionState start = sim->truth(v, s[first].t).state;
      SE3 T = start.T_world_body * mount;
      Vec3 velocity =
          start.v_world_mps + start.T_world_body.R * start.omega_body_radps.cross(mount.p);
      for (std::size_t i = first; i < first + 2000; ++i) {
        const double dt = seconds_between(s[i].t, s[i + 1].t);
        const geometry::Mat3 R =
            T.R * geometry::so3_exp(0.5 * dt * (s[i].gyro_radps + s[i + 1].gyro_radps));
        const Vec3 a =
            0.5 * (T.R * s[i].accel_mps2 + R * s[i + 1].accel_mps2) - Vec3(0.0, 0.0, kGravity_mps2);
        T = {R, T.p + dt * velocity + 0.5 * dt * dt * a};
        velocity += dt * a;
      }
      const SE3 end = sim->truth(v, s[first + 2000].t).state.T_world_body * mount;
      ASSERT_LT((T.p - end.p).norm(), 0.01) << "vehicle " << v << ", sample " << first;
    }
  }
}

}  // namespace
}  // namespace rali::sim
