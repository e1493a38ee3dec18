// Stated errors of the live pose against true ones in the product's configuration: simulated
// sensors through a whole vehicle. Several seeds, since the squared errors of one drive are
// correlated.
#include <algorithm>
#include <variant>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/base/executor.hpp"
#include "rali/sim/simulation.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali {
namespace {

constexpr double kFirst_s = 5.0;  ///< time of the first scored pose after the first of all
constexpr double kApart_s = 2.0;  ///< closer poses have correlated errors

/// Normalised squared error of a position relative to the first pose, per degree of freedom.
double position_nees(const vehicle::PoseEstimate& pose, const geometry::SE3& T_local_body_true) {
  const geometry::Vec6 error = geometry::boxminus(pose.T_local_body, T_local_body_true);
  const geometry::Mat3 P = pose.covariance.bottomRightCorner<3, 3>();
  const geometry::Vec3 e = error.tail<3>();
  return e.dot(P.inverse() * e) / 3.0;
}

/// Mean position NEES of one drive over a storey.
double drive(std::uint64_t seed) {
  sim::SimOptions options;
  options.scene = sim::Scene::kFloor;
  options.seed = seed;
  options.motion.standstill_s = 3.0;
  options.duration_s = 12.0;
  auto simulation = sim::make_simulation(options);
  EXPECT_TRUE(simulation);
  vehicle::VehicleSettings settings;
  settings.has_imu = true;
  settings.calibration = (*simulation)->calibration_nominal();
  vehicle::Vehicle vehicle(VehicleId{0}, settings);
  SerialExecutor executor;
  vehicle::OutputList outputs;
  std::optional<geometry::SE3> T_world_local;
  Time next;
  double sum = 0.0;
  int judged = 0;
  while (const auto message = (*simulation)->next()) {
    outputs.clear();
    std::visit([&](const auto& data) { vehicle.step(data, executor, outputs); }, *message);
    for (const vehicle::Output& output : outputs) {
      const auto* pose = std::get_if<vehicle::PoseEstimate>(&output);
      if (pose == nullptr) continue;
      const geometry::SE3 T_world_body = (*simulation)->truth(pose->t).state.T_world_body;
      if (!T_world_local) {
        T_world_local = T_world_body * pose->T_local_body.inverse();
        next = pose->t + Duration::from_s(kFirst_s);
      }
      if (pose->t < next) continue;
      next = pose->t + Duration::from_s(kApart_s);
      sum += position_nees(*pose, T_world_local->inverse() * T_world_body);
      ++judged;
    }
  }
  EXPECT_GE(judged, 4) << seed;
  return sum / std::max(1, judged);
}

// Measured: mean 0.72, single drives 0.27 to 1.5. Sigmas twice too large or too small fail it.
TEST(LiveNees, of_the_position_is_near_one_over_several_drives) {
  double sum = 0.0;
  constexpr std::uint64_t kSeeds = 6;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const double nees = drive(seed);
    EXPECT_LT(nees, 6.0) << seed;
    sum += nees / static_cast<double>(kSeeds);
  }
  EXPECT_GT(sum, 0.3);
  EXPECT_LT(sum, 2.5);
}

}  // namespace
}  // namespace rali
