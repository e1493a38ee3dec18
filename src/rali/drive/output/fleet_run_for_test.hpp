#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "rali/drive/output/rounds_files.hpp"
#include "rali/map/test_world.hpp"

namespace rali::drive {

/// For tests: a vehicle in a corridor 60 m long and 3 m wide along x, its LiDAR 0.8 m above the
/// ground, odom = map. It reports a pose and a node of its path every half second.
class DrivenVehicle {
 public:
  DrivenVehicle(const std::string& out_dir, std::uint16_t number, SessionFile* session = nullptr)
      : id_{number}, run_(make(out_dir, number, session)) {}

  /// Drives from its position to x_m within the given time; a keyframe at the end.
  DrivenVehicle& drive(double x_m, double duration_s) {
    const double from_m = x_m_;
    const int steps = static_cast<int>(duration_s / 0.5);
    for (int i = 1; i <= steps; ++i) {
      x_m_ = from_m + (x_m - from_m) * i / steps;
      t_s_ += 0.5;
      report(false);
    }
    keyframe();
    return *this;
  }

  DrivenVehicle& stand(double duration_s) {
    for (int i = 1; i <= static_cast<int>(duration_s / 0.5); ++i) {
      t_s_ += 0.5;
      report(true);
    }
    return *this;
  }

  /// Adds an obstacle that stands in the corridor at its keyframes from now on.
  DrivenVehicle& sees(const map::test::Cylinder& cylinder) {
    cylinders_.push_back(cylinder);
    return *this;
  }

  /// Its start position, at t = 0.
  DrivenVehicle& begin(double x_m, bool at_rest) {
    x_m_ = x_m;
    report(at_rest);
    keyframe();
    return *this;
  }

  /// With its frame and its keyframes from the joint estimate.
  [[nodiscard]] VehicleRun finish(const geometry::SE3& T_map_local = {},
                                  KeyframeCorrections keyframes = {}) {
    run_.join(T_map_local, std::move(keyframes));
    EXPECT_TRUE(run_.finish());
    return std::move(run_);
  }

 private:
  static VehicleRun make(const std::string& out_dir, std::uint16_t number, SessionFile* session) {
    Result<VehicleRun> run = VehicleRun::start("v" + std::to_string(number + 1), out_dir, session);
    EXPECT_TRUE(run);
    return std::move(*run);
  }

  void take(vehicle::Output output) {
    FindingList findings;
    EXPECT_TRUE(run_.take({std::move(output)}, findings));
  }

  void report(bool at_rest) {
    vehicle::PoseEstimate pose;
    pose.t = Time::from_s(t_s_);
    pose.T_local_body = map::test::pose_at(x_m_, 1.5, 0.8);
    pose.T_odom_body = pose.T_local_body;
    pose.covariance = 1e-4 * geometry::Mat6::Identity();
    take(pose);
    fleet::Increment step;
    step.at_rest = at_rest;
    const fleet::FactKey key{id_, 0, facts_++};
    take(vehicle::FactMade{std::make_shared<const fleet::Fact>(fleet::Fact{key, pose.t, step})});
  }

  void keyframe() {
    const map::test::Room corridor{{0.0, 0.0, 0.0}, {60.0, 3.0, 3.0}, cylinders_};
    const map::test::Scan scan =
        map::test::look_around(corridor, map::test::pose_at(x_m_, 1.5, 0.8), t_s_);
    auto made = std::make_shared<odometry::Keyframe>();
    made->t = Time::from_s(t_s_);
    made->T_odom_body = scan.T_map_body;
    const map::KeyframeView view = scan.view();
    made->cloud.x_m.assign(view.x_m.begin(), view.x_m.end());
    made->cloud.y_m.assign(view.y_m.begin(), view.y_m.end());
    made->cloud.z_m.assign(view.z_m.begin(), view.z_m.end());
    made->cloud.intensity.assign(view.size(), 1.0F);
    made->cloud.ring.assign(view.size(), 0);
    take(vehicle::KeyframeAdded{{id_, keyframes_++}, made});
  }

  VehicleId id_;
  VehicleRun run_;
  std::vector<map::test::Cylinder> cylinders_;
  double t_s_ = 0.0, x_m_ = 0.0;
  std::uint32_t facts_ = 0, keyframes_ = 0;
};

}  // namespace rali::drive
