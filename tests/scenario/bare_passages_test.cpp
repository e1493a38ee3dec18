// Passages without anything along them: round pipes, where nothing shows roll either, bends, where
// walls stand across the way, inclines, and a corridor seen by lasers with errors.

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/cli/run_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

/// A scene, its recording, and the maps made from it.
class Passage {
 public:
  explicit Passage(const std::string& scene, const std::string& seed = "5") {
    folder_.write("scene.yaml", scene);
    const Outcome made = run_rali(
        {"simulate", folder_.path("scene.yaml"), "-o", folder_.path("sim"), "--seed", seed, "-q"});
    EXPECT_EQ(made.code, kExitDone) << made.err;
  }

  /// Maps into `out`. @return the metrics
  [[nodiscard]] nlohmann::json map(const std::string& out, int exit_code,
                                   const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"map",         folder_.path("sim/fleet.yaml"),
                                   "-o",          folder_.path(out),
                                   "-q",          "--no-mcap",
                                   "--no-report", "--formats",
                                   "ply"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome run = run_rali(words);
    EXPECT_EQ(run.code, exit_code) << run.err;
    return read(out + "/metrics.json");
  }

  /// Compares `out` with the truth.
  [[nodiscard]] nlohmann::json evaluate(const std::string& out) const {
    const Outcome judged =
        run_rali({"evaluate", folder_.path(out), "--truth", folder_.path("sim/truth"), "-q"});
    EXPECT_EQ(judged.code, kExitDone) << judged.out << judged.err;
    return read(out + "/evaluation.json");
  }

 private:
  [[nodiscard]] nlohmann::json read(const std::string& path) const {
    return nlohmann::json::parse(folder_.read(path));
  }

  io::TestFolder folder_;
};

double fleet_error_m(const nlohmann::json& evaluation) {
  return evaluation["fleet"]["trajectory"]["ape_m"]["rmse"].get<double>();
}

constexpr char kPipe[] = R"(schema: 1
tunnel: {length_m: 70, width_m: 1.6, round: true, roughness_m: 0, closed_ends: true}
vehicles:
  - {start: [6, 0]}
  - {start: [9, 0]}
rounds:
  - {anchor: v1, routes: {v2: [[9, 0], [20, 0], [36, 0]]}}
  - {anchor: v2, routes: {v1: [[6, 0], [20, 0], [32, 0]]}}
uwb: {max_range_m: 400}
motion: {speed_mps: 1.0, standstill_s: 6}
duration_s: 0
)";

// The whole way from calibration to map where no surface is flat: a check, a start pose or a join
// that needs planes would refuse one of the vehicles. That roll is not measured there is tested by
// places/align_test.cpp; this recording alone did not fail by it.
TEST(RoundPipe, two_vehicles_end_in_one_frame) {
  const Passage pipe(kPipe);
  EXPECT_EQ(pipe.map("out", kExitDone)["fleet"]["groups"].size(), 1U);
  EXPECT_LT(fleet_error_m(pipe.evaluate("out")), 0.12);
}

constexpr char kInclinedBend[] = R"(schema: 1
tunnel: {length_m: 300, gradient: 0.12, curvature_per_m: 0.005, roughness_m: 0, niche_every_m: 0}
vehicles: 1
duration_s: 50
)";

class InclinedBend : public testing::TestWithParam<const char*> {};

// With a horizontal axis the height above the ground seemed to measure the position along it: 7.4
// and 3.9 m off at the end at a stated 1.3 and 1.5 m, "degenerate: 67 %".
TEST_P(InclinedBend, is_degenerate_along_its_slope) {
  const Passage bend(kInclinedBend, GetParam());
  const nlohmann::json v1 = bend.map("out", kExitDone)["vehicles"]["v1"];
  EXPECT_GT(v1["degenerate_fraction"].get<double>(), 0.9);
  const nlohmann::json trajectory = bend.evaluate("out")["vehicles"]["v1"]["trajectory"];
  EXPECT_LT(2.0 * trajectory["ape_m"]["rmse"].get<double>(), v1["sigma_max_m"].get<double>());
}

INSTANTIATE_TEST_SUITE_P(Seeds, InclinedBend, testing::Values("12", "13"));

/// A bend of 100 m radius; SHAPE is to be replaced.
constexpr char kBend[] = R"(schema: 1
tunnel: {length_m: 110, SHAPE, roughness_m: 0, curvature_per_m: 0.01}
vehicles:
  - {start: [25.708, 3.361], yaw_deg: 14.897}
  - {start: [28.595, 4.176], yaw_deg: 16.616}
rounds:
  - {anchor: v1, routes: {v2: [[28.595, 4.176], [35.695, 6.588], [42.594, 9.525], [49.253, 12.971],
      [55.636, 16.906], [61.706, 21.308], [67.429, 26.153]]}}
uwb: {max_range_m: 400}
motion: {speed_mps: 1.5, standstill_s: 6}
duration_s: 0
)";

class TightBend : public testing::TestWithParam<const char*> {};

// If a shift along the axis counts as measured there, ranges are refused, and the two are 3.6 and
// 2.2 m off. Without ranges, the accelerometer alone leaves up to 4.8 and 8.0 m stated; with the
// turn of the gyro at most 1.6 m (round) and 2.0 m. How far it is off then is chance: 0.26 to 1.04
// m (rmse, round) over seeds 1 to 5, and for seed 5 it differs between machines.
TEST_P(TightBend, is_degenerate_and_ranges_or_the_turn_determine_the_position_along_it) {
  std::string scene = kBend;
  scene.replace(scene.find("SHAPE"), 5, GetParam());
  const Passage bend(scene);
  const nlohmann::json metrics = bend.map("out", kExitDone);
  EXPECT_EQ(metrics["fleet"]["groups"].size(), 1U);
  EXPECT_GT(metrics["ranges"]["used"].get<double>(),
            0.8 * metrics["ranges"]["total"].get<double>());
  EXPECT_LT(fleet_error_m(bend.evaluate("out")), 0.2);
  const nlohmann::json alone =
      bend.map("alone", kExitGaps, {"--set", "ranges.sources=[]", "--set", "priors=[]"});
  EXPECT_LT(alone["vehicles"]["v2"]["sigma_max_m"].get<double>(), 3.0);
  const nlohmann::json odometry = bend.evaluate("alone")["vehicles"]["v2"]["odometry"];
  EXPECT_LT(odometry["ape_m"]["rmse"].get<double>(),
            alone["vehicles"]["v2"]["sigma_max_m"].get<double>());
}

INSTANTIATE_TEST_SUITE_P(Shapes, TightBend,
                         testing::Values("width_m: 4.85, round: true",
                                         "width_m: 6, wall_height_m: 1.5"));

/// Two rooms, and 120 m of corridor between them; LASERS is to be replaced.
constexpr char kCorridor[] = R"(schema: 1
floor_plan:
  height_m: 2.6
  areas:
    - {rectangle: [0, 0, 14, 12]}
    - {rectangle: [14, 4, 134, 6.2]}
    - {rectangle: [134, 0, 146, 12]}
  clutter: 12
vehicles:
  - {start: [3, 3], route: [[3, 3], [10, 9], [11, 5], [16, 5.1], [137, 5.1], [142, 8]]}
motion: {speed_mps: 1.2, standstill_s: 5}
ranging: {LASERS}
)";

Passage long_corridor(const std::string& lasers, const std::string& seed) {
  std::string scene = kCorridor;
  scene.replace(scene.find("LASERS"), 6, lasers);
  return Passage(scene, seed);
}

// Errors of the lasers tilt the map by half a degree over 30 m. Taken for a bias of the
// accelerometer, that is 105 m of speed integrated along the corridor.
TEST(LongCorridor, of_lasers_with_errors_is_off_by_no_more_than_stated) {
  const Passage corridor =
      long_corridor("laser_elevation_deg: 0.1, laser_offset_m: 0.01", "4");  // a worn sensor
  const nlohmann::json metrics = corridor.map("out", kExitDone);
  const double sigma_m = metrics["vehicles"]["v1"]["sigma_max_m"].get<double>();
  EXPECT_LT(sigma_m, 4.0);
  const nlohmann::json judged = corridor.evaluate("out")["vehicles"]["v1"];
  EXPECT_LT(judged["odometry"]["ape_m"]["max"].get<double>(), 1.5) << "in 140 m";
  EXPECT_LT(judged["trajectory"]["ape_m"]["max"].get<double>(), 2.0 * sigma_m);
}

// From its middle a dozen points of a scan lie on the end walls, 70 m away. Summed with the noise
// of all other normals they were nothing: 44 m off, and the final path stated 3.6 m there.
TEST(LongCorridor, is_known_by_the_walls_at_its_ends) {
  const Passage corridor = long_corridor("", "2");
  const nlohmann::json metrics = corridor.map("out", kExitDone);
  EXPECT_LT(metrics["vehicles"]["v1"]["sigma_max_m"].get<double>(), 0.5);
  const nlohmann::json judged = corridor.evaluate("out")["vehicles"]["v1"];
  EXPECT_LT(judged["odometry"]["ape_m"]["max"].get<double>(), 0.3);
  EXPECT_LT(judged["trajectory"]["ape_m"]["max"].get<double>(), 0.3);
}

// Not measured, such lasers leave 0.50 m; measured, 0.26 m.
TEST(LongCorridor, is_known_as_well_if_its_lasers_are_held_for_far_worse_than_they_show_to_be) {
  const Passage corridor = long_corridor("", "2");
  const nlohmann::json metrics =
      corridor.map("out", kExitDone, {"--set", "settings.odometry.robust.drift.laser_sigma_deg=1"});
  EXPECT_LT(metrics["vehicles"]["v1"]["sigma_max_m"].get<double>(), 0.35);
}

}  // namespace
}  // namespace rali::cli
