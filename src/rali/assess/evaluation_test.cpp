#include "rali/assess/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/assess/evaluate_words.hpp"
#include "rali/assess/mesh_input.hpp"
#include "rali/assess/outputs.hpp"
#include "rali/io/files/mesh_file.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/io/files/tum.hpp"

namespace rali::assess {
namespace {

using geometry::SE3;
using geometry::Vec3;
using io::TestFolder;

SE3 at(double x, double y, double z, double yaw_rad = 0.0) {
  return {geometry::rotation_from_rpy(0.0, 0.0, yaw_rad), Vec3(x, y, z)};
}

/// A quarter circle of 10 m radius in 10 s, shifted sideways.
SE3 on_curve(double t_s, double y_m = 0.0) {
  const double a = 0.05 * std::numbers::pi * t_s;
  return at(10.0 * std::sin(a), 10.0 - 10.0 * std::cos(a) + y_m, 0.0, a);
}

/// TUM text of poses each `step_s` from start_s on.
template <class F>
std::string tum(double start_s, double step_s, int n, const F& pose) {
  std::string text;
  for (int i = 0; i < n; ++i) {
    text += io::tum_line({Time::from_s(start_s + step_s * i), pose(step_s * i)}) + '\n';
  }
  return text;
}

void make_folders(const TestFolder& f) {
  for (const char* name : {"out/trajectory", "out/odometry", "out/degeneracy", "truth"}) {
    std::filesystem::create_directories(f.path(name));
  }
}

/// v1 is perfect; v2's estimate is 0.6 m beside its ground truth. Each has a frame of its own kind.
void write_fleet(const TestFolder& f) {
  make_folders(f);
  const SE3 frame = at(3.0, -1.0, 0.0, 0.4);
  f.write("truth/v1.tum", tum(100, 0.01, 1001, [](double t) { return on_curve(t); }));
  f.write("truth/v2.tum", tum(100, 0.01, 1001, [](double t) { return on_curve(t, 4.0); }));
  f.write("out/trajectory/v1.tum",
          tum(100, 0.1, 100, [&](double t) { return frame * on_curve(t); }));
  f.write("out/trajectory/v2.tum",
          tum(100, 0.1, 100, [&](double t) { return frame * on_curve(t, 4.6); }));
}

Result<Evaluation> evaluated(const TestFolder& f, EvaluationOptions options = {}) {
  Result<RunInput> run = read_run(f.path("out"));
  if (!run) return tl::make_unexpected(run.error());
  if (Status s = add_truth(f.path("truth"), SE3{}, *run); !s) return tl::make_unexpected(s.error());
  return evaluate_tracks(*run, options);
}

TEST(Evaluation, joint_alignment_shows_the_relative_shift_that_per_vehicle_alignment_hides) {
  const TestFolder f;
  write_fleet(f);
  const auto e = evaluated(f);
  ASSERT_TRUE(e) << e.error().message();
  ASSERT_EQ(e->vehicles.size(), 2U);
  EXPECT_NEAR(e->fleet.ape_m.rmse, 0.300, 2e-3);
  EXPECT_NEAR(*e->vehicles[0].trajectory.alone_rmse_m, 0.0, 1e-5);
  EXPECT_NEAR(*e->vehicles[1].trajectory.alone_rmse_m, 0.0, 1e-5);
  ASSERT_EQ(e->between.size(), 1U);
  EXPECT_NEAR(e->between[0].translation_m.rmse, 0.6, 1e-5);
  EvaluationOptions each;
  each.each = true;
  const auto alone = evaluated(f, each);
  ASSERT_TRUE(alone);
  EXPECT_NEAR(alone->fleet.ape_m.rmse, 0.0, 1e-5);
  EXPECT_NEAR(alone->between[0].translation_m.rmse, 0.6, 1e-5);
  EXPECT_NE(alone->how().find("one per vehicle"), std::string::npos);
}

TEST(Evaluation, a_folder_with_only_live_poses_is_evaluated_as_one_fleet) {
  const TestFolder f;
  write_fleet(f);
  std::filesystem::rename(f.path("out/trajectory"), f.path("out/live"));
  f.write("out/live/v3.tum", "# never placed in the map\n");
  const auto e = evaluated(f);
  ASSERT_TRUE(e) << e.error().message();
  ASSERT_EQ(e->vehicles.size(), 2U);
  EXPECT_NEAR(e->fleet.ape_m.rmse, 0.300, 2e-3);
  EXPECT_FALSE(e->vehicles[0].live) << "they are not judged twice";
}

TEST(Evaluation, vehicles_in_separate_frames_are_aligned_per_frame) {
  const TestFolder f;
  write_fleet(f);
  f.write("out/metrics.json", R"({"fleet": {"groups": [["v1"], ["v2"]]}})");
  const auto e = evaluated(f);
  ASSERT_TRUE(e);
  EXPECT_EQ(e->frames.size(), 2U);
  EXPECT_TRUE(e->between.empty());
  EXPECT_NEAR(e->fleet.ape_m.rmse, 0.0, 1e-5);
  EXPECT_NE(e->how().find("one for each of 2 frames"), std::string::npos);
}

TEST(Evaluation, reports_the_number_of_poses_and_the_evaluated_fraction_of_time) {
  const TestFolder f;
  make_folders(f);
  f.write("truth/v1.tum", tum(100, 0.01, 2001, [](double t) { return on_curve(t); }));
  f.write("out/trajectory/v1.tum", tum(100, 0.1, 101, [](double t) { return on_curve(t); }));
  const auto e = evaluated(f);
  ASSERT_TRUE(e);
  EXPECT_EQ(e->fleet.poses, 101U);
  EXPECT_NEAR(e->fleet.time_fraction, 0.5, 1e-3);
  EXPECT_EQ(e->how(), "alignment se3; truth interpolated, gaps above 0.2 s left out");
}

TEST(Evaluation, degenerate_errors_and_nees_use_the_tables_of_the_run) {
  const TestFolder f;
  make_folders(f);
  f.write("truth/v1.tum", tum(100, 0.01, 1001, [](double t) { return on_curve(t); }));
  // From 2 s on 0.3 m ahead along x of the map, with a sigma of 0.3 m there: e' P^-1 e = 1.
  f.write("out/trajectory/v1.tum", tum(100, 0.1, 100, [](double t) {
            return t < 1.95 ? on_curve(t) : at(0.3, 0, 0) * on_curve(t);
          }));
  std::string cov = "stamp_s", degenerate = "stamp_s,degenerate,degree,dir_x,dir_y,dir_z\n";
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) cov += fmt::format(",c{}{}", r, c);
  }
  cov += '\n';
  for (int i = 0; i < 90; ++i) {
    cov += fmt::format("{:.9f}", 100.0 + 0.1 * i);
    for (int r = 0; r < 6; ++r) {
      for (int c = r; c < 6; ++c) cov += r != c ? ",0" : (r == 0 ? ",0.09" : ",1e-4");
    }
    cov += '\n';
    degenerate += fmt::format("{:.9f},{},,1,0,0\n", 100.0 + 0.1 * i, i >= 50 ? 1 : 0);
  }
  f.write("out/trajectory/v1.cov.csv", cov);
  f.write("out/degeneracy/v1.csv", degenerate);
  EvaluationOptions options;
  options.align = eval::Alignment::kNone;
  const auto e = evaluated(f, options);
  ASSERT_TRUE(e) << e.error().message();
  const TrackScore& s = e->vehicles[0].trajectory;
  ASSERT_TRUE(s.degenerate && s.nees6);
  EXPECT_EQ(s.degenerate->along_m.count, 40U);
  EXPECT_NEAR(s.degenerate->along_m.mean, 0.3, 1e-5);
  EXPECT_NEAR(s.degenerate->across_m.max, 0.0, 1e-4);
  EXPECT_EQ(s.nees6->poses, 90U);
  EXPECT_EQ(s.covariances_unusable, 10U);
  EXPECT_NEAR(s.nees6->mean, 70.0 / 90.0, 1e-3);
  EXPECT_EQ(s.nees6->fraction_within_95, 1.0);
  EXPECT_FALSE(e->vehicles[0].rows[10].along_degenerate_m);
}

/// A quarter circle that climbs by 0.4 m in the estimate and not at all in the ground truth.
std::string climbing() {
  return tum(100, 0.1, 101, [](double t) { return at(0, 0, 0.04 * t) * on_curve(t); });
}

std::optional<double> drift_in_height(const TestFolder& f, const EvaluationOptions& options = {}) {
  const auto e = evaluated(f, options);
  EXPECT_TRUE(e) << (e ? "" : e.error().message());
  return e ? e->vehicles[0].trajectory.drift->z_m : std::nullopt;
}

TEST(Evaluation, height_drift_is_evaluated_only_if_the_estimate_is_gravity_aligned) {
  const TestFolder f;
  make_folders(f);
  f.write("truth/v1.tum", tum(100, 0.01, 1001, [](double t) { return on_curve(t); }));
  const std::string levelled = "# " + io::frame_line(true) + '\n';
  f.write("out/trajectory/v1.tum", levelled + climbing());
  ASSERT_TRUE(drift_in_height(f));
  EXPECT_NEAR(*drift_in_height(f), 0.4, 1e-6);
  f.write("out/trajectory/v1.tum", "# " + io::frame_line(false) + '\n' + climbing());
  EXPECT_FALSE(drift_in_height(f)) << "without inertial data z is not up";
  const auto e = evaluated(f);
  ASSERT_TRUE(e);
  EXPECT_NE(evaluation_table(*e).find("  in height [m]                        -\n"),
            std::string::npos)
      << evaluation_table(*e);
  const auto json = nlohmann::json::parse(evaluation_json(*e, {}));
  EXPECT_TRUE(json["vehicles"]["v1"]["trajectory"]["drift_z_m"].is_null());
}

TEST(Evaluation, height_without_a_header_is_evaluated_with_yaw_or_no_alignment) {
  const TestFolder f;
  make_folders(f);
  f.write("truth/v1.tum", tum(100, 0.01, 1001, [](double t) { return on_curve(t); }));
  f.write("out/trajectory/v1.tum", climbing());
  EvaluationOptions options;
  EXPECT_FALSE(drift_in_height(f, options)) << "no header says that z is up";
  options.align = eval::Alignment::kYaw;
  EXPECT_TRUE(drift_in_height(f, options));
  options.align = eval::Alignment::kNone;
  EXPECT_TRUE(drift_in_height(f, options));
  f.write("out/trajectory/v1.tum", "# " + io::frame_line(false) + '\n' + climbing());
  EXPECT_FALSE(drift_in_height(f, options)) << "the file says that it is not";
}

TEST(Evaluation, ground_truth_of_a_prism_is_transformed_to_the_body_frame) {
  const TestFolder f;
  make_folders(f);
  const auto T_body_prism = parse_pose("0.2,-0.1,1.5,0,0,90");
  ASSERT_TRUE(T_body_prism);
  f.write("truth/v1.tum",
          tum(100, 0.01, 1001, [&](double t) { return on_curve(t) * *T_body_prism; }));
  f.write("out/trajectory/v1.tum", tum(100, 0.1, 100, [](double t) { return on_curve(t); }));
  Result<RunInput> run = read_run(f.path("out"));
  ASSERT_TRUE(run && add_truth(f.path("truth"), *T_body_prism, *run));
  EvaluationOptions options;
  options.align = eval::Alignment::kNone;
  const auto e = evaluate_tracks(*run, options);
  ASSERT_TRUE(e);
  EXPECT_NEAR(e->fleet.ape_m.max, 0.0, 1e-5);
  EXPECT_NEAR(e->fleet.rotation_rad.max, 0.0, 1e-5);
}

TEST(Evaluation, a_straight_path_is_aligned_by_yaw_with_a_warning) {
  const TestFolder f;
  make_folders(f);
  f.write("truth/v1.tum", tum(0, 0.01, 1001, [](double t) { return at(t, 0, 0); }));
  f.write("out/trajectory/v1.tum",
          tum(0, 0.1, 100, [](double t) { return at(0, t, 0, 1.5707963); }));
  const auto e = evaluated(f);
  ASSERT_TRUE(e);
  EXPECT_EQ(e->frames[0].used, eval::Alignment::kYaw);
  EXPECT_NEAR(e->fleet.ape_m.max, 0.0, 1e-4);
  ASSERT_EQ(e->warnings.size(), 1U);
  EXPECT_NE(e->warnings[0].find("the path is straight"), std::string::npos);
}

TEST(Evaluation, a_single_pose_of_a_standing_vehicle_is_evaluated) {
  const TestFolder f;
  make_folders(f);
  f.write("truth/v1.tum", tum(0, 0.01, 101, [](double) { return at(1, 2, 3); }));
  f.write("out/trajectory/v1.tum", tum(0.5, 0.1, 1, [](double) { return at(0, 0, 0); }));
  const auto e = evaluated(f);
  ASSERT_TRUE(e) << e.error().message();
  EXPECT_EQ(e->frames[0].used, eval::Alignment::kOrigin);
  EXPECT_EQ(e->fleet.poses, 1U);
  EXPECT_NEAR(e->fleet.ape_m.max, 0.0, 1e-9);
  EXPECT_FALSE(evaluation_table(*e).empty());
}

TEST(Evaluation, invalid_input_is_refused_with_its_file_name) {
  const TestFolder f;
  EXPECT_FALSE(read_run(f.path("nothing")));
  std::filesystem::create_directories(f.path("out"));
  EXPECT_NE(read_run(f.path("out")).error().message().find("trajectory"), std::string::npos);
  write_fleet(f);
  f.write("out/trajectory/v1.tum", "2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n");
  EXPECT_NE(evaluated(f).error().message().find("v1.tum:2"), std::string::npos);
  f.write("out/trajectory/v1.tum", "1 nan 0 0 0 0 0 1\n");
  EXPECT_NE(evaluated(f).error().message().find("v1.tum:1"), std::string::npos);
  f.write("out/trajectory/v1.tum", "");
  EXPECT_FALSE(evaluated(f));
  write_fleet(f);
  f.write("out/trajectory/v1.cov.csv", "stamp_s,c00\n1,2\n");
  EXPECT_NE(evaluated(f).error().message().find("c01"), std::string::npos);
  std::filesystem::remove(f.path("out/trajectory/v1.cov.csv"));
  f.write("out/metrics.json", "{\"fleet\": {\"groups\": [[1, null], 7, [\"v1\", \"v1\"]]}}");
  EXPECT_TRUE(evaluated(f));
  std::filesystem::remove(f.path("truth/v1.tum"));
  const auto one = evaluated(f);
  ASSERT_TRUE(one);
  EXPECT_EQ(one->vehicles.size(), 1U);
  EXPECT_EQ(one->warnings.size(), 1U);
  std::filesystem::remove(f.path("truth/v2.tum"));
  EXPECT_NE(evaluated(f).error().message().find("v1.tum, v2.tum"), std::string::npos);
}

TEST(Evaluation, cloud_is_aligned_to_the_mesh_by_the_trajectory_and_icp) {
  const TestFolder f;
  const std::vector<geometry::Vec3f> v{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
  const std::vector<std::array<std::uint32_t, 3>> t{{0, 1, 2}, {0, 2, 3}};
  ASSERT_TRUE(io::write_mesh_ply(f.path("m.ply"), v, t, {}));
  const auto mesh = read_mesh(f.path("m.ply"));
  ASSERT_TRUE(mesh);
  std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 400\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n";
  for (int i = 0; i < 400; ++i) ply += fmt::format("{} {} 1.02\n", 0.2 * (i % 20), 0.2 * (i / 20));
  const auto points = read_points(f.write("cloud.ply", ply));
  ASSERT_TRUE(points);
  SerialExecutor serial;
  Evaluation e;
  e.options.mesh_icp = true;
  ASSERT_TRUE(evaluate_cloud("cloud.ply", *points, &*mesh, at(0, 0, -1), serial, e));
  EXPECT_NEAR(e.cloud->before_icp->within.mean, 0.02, 1e-6);
  EXPECT_NEAR(e.cloud->to_mesh->within.mean, 0.0, 1e-6);
  EXPECT_FALSE(read_mesh(f.write("cloud_only.ply", ply)));
  EXPECT_FALSE(read_points(f.write("empty.ply", "")));
}

TEST(Outputs, json_contains_the_metrics_and_is_deterministic) {
  const TestFolder f;
  write_fleet(f);
  const auto e = evaluated(f);
  ASSERT_TRUE(e && write_evaluation(f.path("out"), *e, {}));
  const std::string text = f.read("out/evaluation.json");
  EXPECT_EQ(text, evaluation_json(*evaluated(f), {}));
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json["schema"], 2);
  EXPECT_NEAR(json["fleet"]["trajectory"]["ape_m"]["rmse"].get<double>(), e->fleet.ape_m.rmse,
              1e-11);
  EXPECT_EQ(json["vehicles"]["v1"]["trajectory"]["poses"], 100);
  EXPECT_TRUE(json["cloud"].is_null());
  const std::string csv = f.read("out/errors/v2.csv");
  EXPECT_TRUE(
      csv.starts_with("stamp_s,ape_m,rot_deg,ex,ey,ez,along_degenerate_m,nees\n100.000000000,"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 101);
}

TEST(Outputs, are_added_to_status_json_without_other_changes) {
  const TestFolder f;
  write_fleet(f);
  f.write("out/status.json",
          R"({"schema": 1, "rali": "x", "status": "partial", "files": {"map.pcd": "00"}})");
  const auto e = evaluated(f);
  ASSERT_TRUE(e && write_evaluation(f.path("out"), *e, {}));
  const auto status = nlohmann::json::parse(f.read("out/status.json"));
  EXPECT_EQ(status["status"], "partial");
  EXPECT_EQ(status["files"]["map.pcd"], "00");
  EXPECT_EQ(status["files"].size(), 4U);
  EXPECT_EQ(status["files"]["errors/v1.csv"].get<std::string>().size(), 64U);
  f.write("out/status.json", "not json");
  ASSERT_TRUE(write_evaluation(f.path("out"), *e, {}));
  EXPECT_EQ(f.read("out/status.json"), "not json");
}

TEST(Outputs, table_of_ten_vehicles_fits_eighty_columns) {
  Evaluation e;
  e.options.distances_m = {1, 10, 50};
  for (int i = 0; i < 10; ++i) {
    VehicleScore v;
    v.name = fmt::format("vehicle{}", i);
    v.trajectory.poses = 1000000;
    v.trajectory.ape_m.count = 1;
    v.trajectory.ape_m.rmse = 12345.678;
    e.vehicles.push_back(v);
  }
  std::string_view text;
  const std::string table = evaluation_table(e);
  text = table;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    EXPECT_LE(end, 80U) << text.substr(0, end);
    text.remove_prefix(end + 1);
  }
  EXPECT_NE(table.find("vehicle9"), std::string::npos);
}

}  // namespace
}  // namespace rali::assess
