// The gauge of covariances: the reference of the frame (docs/reference/evaluation.md).
#include <cmath>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/assess/evaluation.hpp"
#include "rali/assess/outputs.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/io/files/tum.hpp"

namespace rali::assess {
namespace {

using geometry::SE3;
using geometry::Vec3;
using io::TestFolder;

constexpr int kPoses = 100;

SE3 at(double x, double y, double yaw_rad = 0.0) {
  return {geometry::rotation_from_rpy(0.0, 0.0, yaw_rad), Vec3(x, y, 0.0)};
}

/// A quarter circle of 10 m radius in 10 s.
SE3 on_curve(double t_s) {
  const double a = 0.05 * std::numbers::pi * t_s;
  return at(10.0 * std::sin(a), 10.0 - 10.0 * std::cos(a), a);
}

template <class F>
std::string tum(double step_s, int n, const F& pose) {
  std::string text;
  for (int i = 0; i < n; ++i) {
    text += io::tum_line({Time::from_s(100.0 + step_s * i), pose(step_s * i)}) + '\n';
  }
  return text;
}

/// The same sigma for every pose and every direction, metres and radians.
std::string covariances(double sigma) {
  std::string text = "stamp_s";
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) text += fmt::format(",c{}{}", r, c);
  }
  text += '\n';
  for (int i = 0; i < kPoses; ++i) {
    text += fmt::format("{:.9f}", 100.0 + 0.1 * i);
    for (int r = 0; r < 6; ++r) {
      for (int c = r; c < 6; ++c) text += r == c ? fmt::format(",{}", sigma * sigma) : ",0";
    }
    text += '\n';
  }
  return text;
}

/// v1 is at standstill at the map's origin with a stated sigma of 0.01 mm. v2 drives, is 0.2 m
/// beside its ground truth, and states 0.1 m: e' P^-1 e = 4.
void write_fleet(const TestFolder& f) {
  for (const char* name : {"out/trajectory", "out/live", "truth"}) {
    std::filesystem::create_directories(f.path(name));
  }
  const SE3 T_map_world = at(3.0, -1.0, 0.4);
  f.write("truth/v1.tum", tum(0.01, 1001, [](double) { return at(5, 5); }));
  f.write("truth/v2.tum", tum(0.01, 1001, [](double t) { return on_curve(t); }));
  const auto standing = [&](double) { return T_map_world * at(5, 5); };
  const auto driving = [&](double t) { return at(0, 0.2) * T_map_world * on_curve(t); };
  f.write("out/trajectory/v1.tum", tum(0.1, kPoses, standing));
  f.write("out/trajectory/v1.cov.csv", covariances(1e-5));
  f.write("out/trajectory/v2.tum", tum(0.1, kPoses, driving));
  f.write("out/trajectory/v2.cov.csv", covariances(0.1));
}

Result<Evaluation> evaluated(const TestFolder& f, const EvaluationOptions& options = {}) {
  Result<RunInput> run = read_run(f.path("out"));
  if (!run) return tl::make_unexpected(run.error());
  if (Status s = add_truth(f.path("truth"), SE3{}, *run); !s) return tl::make_unexpected(s.error());
  return evaluate_tracks(*run, options);
}

TEST(GaugeOfRun, the_reference_vehicle_has_no_nees_and_others_are_relative_to_it) {
  const TestFolder f;
  write_fleet(f);
  const auto e = evaluated(f);
  ASSERT_TRUE(e) << e.error().message();
  const TrackScore& v1 = e->vehicles[0].trajectory;
  EXPECT_FALSE(v1.nees6) << "it is the reference";
  EXPECT_EQ(v1.reference_poses, kPoses);
  EXPECT_EQ(v1.covariances_unusable, 0U);
  const TrackScore& v2 = e->vehicles[1].trajectory;
  ASSERT_TRUE(v2.nees3);
  EXPECT_EQ(v2.reference_poses, 0U);
  EXPECT_NEAR(v2.nees3->mean, 4.0, 1e-2) << "a best fit would share the error out";
  EXPECT_NEAR(e->fleet.nees6->mean, 4.0, 1e-2);
  EXPECT_EQ(e->fleet.nees6->poses, kPoses);
  const auto json = nlohmann::json::parse(evaluation_json(*e, {}));
  EXPECT_EQ(json["fleet"]["trajectory"]["reference_poses"], kPoses);
  EXPECT_TRUE(json["vehicles"]["v1"]["trajectory"]["nees_pose"].is_null());
}

TEST(GaugeOfRun, per_vehicle_alignment_does_not_change_the_reference_of_nees) {
  const TestFolder f;
  write_fleet(f);
  EvaluationOptions each;
  each.each = true;
  const auto e = evaluated(f, each);
  ASSERT_TRUE(e);
  EXPECT_NEAR(e->vehicles[1].trajectory.ape_m.rmse, 0.0, 1e-4);
  EXPECT_NEAR(e->vehicles[1].trajectory.nees3->mean, 4.0, 1e-2);
}

TEST(GaugeOfRun, the_first_vehicle_of_a_group_is_the_reference) {
  const TestFolder f;
  write_fleet(f);
  f.write("out/metrics.json", R"({"fleet": {"groups": [["v2", "v1"]]}})");
  const auto e = evaluated(f);
  ASSERT_TRUE(e);
  ASSERT_EQ(e->vehicles[0].name, "v2");
  EXPECT_EQ(e->vehicles[0].trajectory.reference_poses, 1U);
  EXPECT_NEAR(e->vehicles[0].trajectory.nees3->mean, 0.0, 1e-3) << "its way has no other error";
  EXPECT_GT(e->vehicles[1].trajectory.nees3->mean, 1e6) << "0.2 m off, 0.01 mm stated";
}

TEST(GaugeOfRun, without_reference_ground_truth_the_pose_of_smallest_covariance_is_used) {
  const TestFolder f;
  write_fleet(f);
  std::filesystem::remove(f.path("truth/v1.tum"));
  const auto e = evaluated(f);
  ASSERT_TRUE(e);
  ASSERT_EQ(e->vehicles.size(), 1U);
  EXPECT_EQ(e->vehicles[0].trajectory.reference_poses, 1U);
}

TEST(GaugeOfRun, live_poses_are_evaluated_in_the_live_map_frame) {
  const TestFolder f;
  write_fleet(f);
  // The live map has another origin; v2 joins after 5 s, 0.3 m off, and states 0.1 m.
  const SE3 T_live_world = at(-7.0, 2.0, 1.1);
  f.write("out/live/v1.tum", tum(0.1, kPoses, [&](double) { return T_live_world * at(5, 5); }));
  f.write("out/live/v1.cov.csv", covariances(1e-5));
  std::string late;
  for (int i = 50; i < kPoses; ++i) {
    const SE3 T = at(0.3, 0) * T_live_world * on_curve(0.1 * i);
    late += io::tum_line({Time::from_s(100.0 + 0.1 * i), T}) + '\n';
  }
  f.write("out/live/v2.tum", late);
  f.write("out/live/v2.cov.csv", covariances(0.1));
  const auto e = evaluated(f);
  ASSERT_TRUE(e) << e.error().message();
  ASSERT_TRUE(e->vehicles[0].live && e->vehicles[1].live && e->fleet_live);
  EXPECT_FALSE(e->vehicles[0].live->nees6);
  EXPECT_EQ(e->vehicles[1].live->poses, 50U);
  EXPECT_NEAR(e->vehicles[1].live->nees3->mean, 9.0, 2e-2);
  EXPECT_NEAR(e->vehicles[1].trajectory.nees3->mean, 4.0, 1e-2);
  EXPECT_NE(evaluation_table(*e).find("live (in map, at the time)"), std::string::npos);
  const auto json = nlohmann::json::parse(evaluation_json(*e, {}));
  EXPECT_NEAR(json["fleet"]["live"]["nees_position"]["mean"].get<double>(), 9.0, 2e-2);
}

}  // namespace
}  // namespace rali::assess
