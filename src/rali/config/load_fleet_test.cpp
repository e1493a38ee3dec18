#include "rali/config/load_fleet.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "rali/config/imu_models.hpp"

namespace rali::config {
namespace {

Result<FleetConfig> parse(std::string_view text, const Overrides& overrides = {}) {
  return parse_fleet(text, "fleet.yaml", "/data/run", overrides);
}

std::string error_of(std::string_view text, const Overrides& overrides = {}) {
  const Result<FleetConfig> config = parse(text, overrides);
  return config ? "" : config.error().message();
}

constexpr std::string_view kComplete = R"(schema: 1
preset: robust
vehicles:
  v1:
    recording: v1.bag
    start_s: 0
    lidar:
      topic: auto
      model: rs16
      point_time: absolute_s
      header_stamp: end
      deskewed: false
      returns: strongest
      range_m: [0.5, 90]
      T_body_lidar: {xyz_m: [0.08, 0, 0.25], rpy_deg: [0, 0, 90]}
      time_offset_s: 0.02
    imu:
      topic: /imu
      model: bmi088
      accel_unit: g
      gyro_unit: deg_s
      noise: {accel_mps2_rthz: 0.004}
      vibration_factor: 5
      T_body_imu: {xyz_m: [0, 0, 0], rpy_deg: [0, 0, 0]}
    antennas: {uwb: {xyz_m: [0, 0, 0.4]}, back: {xyz_m: [-0.3, 0, 0.4]}}
    self_box_m: [-0.3, 0.3, -0.2, 0.2, -0.1, 0.3]
  v2:
    recording: [a.mcap, /abs/b.mcap]
ranges:
  sources:
    - {file: ranges.csv}
    - {topic: /nlink_linktrack_nodeframe2, ids: {0: v1, 1: v2/uwb}}
    - {serial_log: v1.nlink, vehicle: v1, ids: {7: v1/back}}
  stamp: record
  latency_s: 0.03
  sigma_m: 0.10
  bias_m: {v1-v2: 0.12}
  limits_m: [0.2, 200]
radio: {file: radio.csv}
clock: offset
priors:
  - {vehicle: v2, relative_to: v1, xyz_m: [1, 2, 0], yaw_deg: 30, sigma_m: 0.2, sigma_deg: 3}
rounds: rounds.csv
output: {frame: body, map_voxel_m: 0.1, grid: {cell_m: 0.1, z_m: [0.2, 1.4]}, georeference: marks.csv}
settings:
  vehicle: {imu_wait_s: 0.4}
  checks: {extrinsics: warn}
)";

TEST(LoadFleet, one_vehicle_with_a_recording_is_enough) {
  const Result<FleetConfig> config = parse("vehicles: {v1: {recording: v1.bag}}\n");
  ASSERT_TRUE(config) << config.error().message();
  ASSERT_EQ(config->vehicles.size(), 1U);
  EXPECT_EQ(config->vehicles[0].recordings, std::vector<std::string>{"/data/run/v1.bag"});
  EXPECT_EQ(config->vehicles[0].lidar.T_body_lidar.source, Extrinsics::Source::kAuto);
  EXPECT_EQ(config->preset, "robust");
  EXPECT_EQ(config->origins.at("vehicles.v1.recording"), "fleet.yaml:1");
}

TEST(LoadFleet, every_documented_key_is_read) {
  const Result<FleetConfig> config = parse(kComplete);
  ASSERT_TRUE(config) << config.error().message();
  const VehicleConfig& v1 = config->vehicles.at(0);
  EXPECT_EQ(v1.lidar.cloud.model, "rs16");
  EXPECT_EQ(v1.lidar.cloud.point_time, wire::PointTime::kAbsoluteS);
  EXPECT_EQ(v1.lidar.cloud.header_stamp, wire::HeaderStamp::kEnd);
  EXPECT_EQ(v1.lidar.cloud.range_m[1], 90.0);
  // 90 deg left: the LiDAR's x is the body's y.
  EXPECT_NEAR(v1.lidar.T_body_lidar.T.R(1, 0), 1.0, 1e-12);
  EXPECT_EQ(v1.lidar.T_body_lidar.T.p.z(), 0.25);
  EXPECT_EQ(v1.lidar.time_offset_s.value_or(0.0), 0.02);
  EXPECT_EQ(v1.imu.accel_unit, AccelUnit::kG);
  EXPECT_EQ(v1.antennas.at(1).name, "back");
  EXPECT_EQ(v1.antennas.at(1).p_body_m.x(), -0.3);
  ASSERT_TRUE(v1.self_box_m);
  EXPECT_EQ((*v1.self_box_m)[5], 0.3);
  EXPECT_EQ(config->vehicles.at(1).recordings.at(1), "/abs/b.mcap");
  ASSERT_EQ(config->ranges.sources.size(), 3U);
  EXPECT_EQ(config->ranges.sources[1].ids.at(1).antenna, "uwb");
  EXPECT_EQ(config->ranges.pair_bias_m.at("v1-v2"), 0.12);
  EXPECT_EQ(config->clock, Clock::kOffset);
  EXPECT_EQ(config->priors.at(0).yaw_deg, 30.0);
  EXPECT_EQ(config->rounds, "/data/run/rounds.csv");
  EXPECT_EQ(config->settings.map.grid.z_m[1], 1.4);
  EXPECT_EQ(config->settings.checks.extrinsics, CheckAction::kWarn);
}

TEST(LoadFleet, the_dump_is_valid_input_and_loads_to_the_same_values) {
  const Result<FleetConfig> config = parse(kComplete);
  ASSERT_TRUE(config);
  const std::string dumped = dump_fleet(*config, "/data/run/out");
  EXPECT_NE(dumped.find("recording: ../v1.bag"), std::string::npos) << dumped;
  EXPECT_NE(dumped.find("# fleet.yaml:5"), std::string::npos);
  EXPECT_NE(dumped.find("# preset robust"), std::string::npos);
  EXPECT_NE(dumped.find("# default"), std::string::npos);
  const Result<FleetConfig> again =
      parse_fleet(dumped, "settings.yaml", "/data/run/out", Overrides{});
  ASSERT_TRUE(again) << again.error().message() << '\n' << dumped;
  EXPECT_EQ(hash_fleet(*again), hash_fleet(*config));
  EXPECT_EQ(again->vehicles[0].lidar.T_body_lidar.T.R, config->vehicles[0].lidar.T_body_lidar.T.R);
}

TEST(LoadFleet, a_pose_is_unchanged_bit_by_bit_after_dump_and_load) {
  Result<FleetConfig> config = parse("vehicles: {v1: {recording: v1.bag}}\n");
  ASSERT_TRUE(config);
  Extrinsics& pose = config->vehicles[0].lidar.T_body_lidar;
  pose.source = Extrinsics::Source::kGiven;
  pose.T.R = geometry::rotation_from_rpy(0.1, -0.2, 2.3);
  pose.T.p = geometry::Vec3(1.0 / 3.0, -2.0, 0.1);
  const Result<FleetConfig> again = parse(dump_fleet(*config, "/data/run"));
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->vehicles[0].lidar.T_body_lidar.T.R, pose.T.R);
  EXPECT_EQ(again->vehicles[0].lidar.T_body_lidar.T.p, pose.T.p);
}

TEST(LoadFleet, extrinsic_keys_of_other_systems_get_a_hint_on_key_and_direction) {
  const auto lidar = [](const std::string& key) {
    return error_of("vehicles:\n  v1:\n    recording: a\n    lidar:\n      " + key + ": 1\n");
  };
  EXPECT_EQ(lidar("T_lidar_body"),
            "fleet.yaml:5: unknown key 'T_lidar_body'. The key here is T_body_lidar, the pose of "
            "the LiDAR in the body: write the inverse of yours.");
  EXPECT_NE(lidar("extrinsicRot").find("write the inverse"), std::string::npos);
  EXPECT_NE(lidar("extrinsic_T").find("do not invert"), std::string::npos);
  EXPECT_NE(lidar("T_imu_lidar").find("do not invert"), std::string::npos);
  EXPECT_NE(lidar("T_lidar_imu").find("write the inverse"), std::string::npos);
}

TEST(LoadFleet, an_invalid_rotation_is_refused) {
  const auto pose = [](const std::string& value) {
    return error_of("vehicles:\n  v1:\n    recording: a\n    lidar:\n      T_body_lidar: " + value +
                    "\n");
  };
  EXPECT_EQ(pose("{matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}"), "");
  EXPECT_EQ(pose("{quat_xyzw: [0, 0, 0, 1]}"), "");
  EXPECT_EQ(pose("{from_tf: rslidar}"), "");
  EXPECT_EQ(pose("{matrix: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}"),
            "fleet.yaml:5: vehicles.v1.lidar.T_body_lidar.matrix has determinant -1: it mirrors. "
            "One axis has the wrong sign, or the sensor's frame is left-handed.");
  EXPECT_NE(pose("{matrix: [[1, 0, 0], [0, 1, 0], [0, 0.5, 1]]}").find("not orthonormal"),
            std::string::npos);
  EXPECT_NE(pose("{matrix: [1, 0, 0]}").find("is a"), std::string::npos);
  EXPECT_NE(pose("{matrix: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}").find("3x3"),
            std::string::npos);
  EXPECT_NE(pose("{quat_xyzw: [1, 0, 0, 1]}").find("has length 1.414, not 1"), std::string::npos);
  EXPECT_NE(pose("{quat_xyzw: [0, 0, 0, 1], rpy_deg: [0, 0, 0]}").find("two rotations"),
            std::string::npos);
  EXPECT_NE(pose("{from_tf: a, xyz_m: [0, 0, 0]}").find("from_tf and numbers"), std::string::npos);
  EXPECT_NE(pose("{}").find("is empty"), std::string::npos);
  EXPECT_NE(pose("{rpy: [0, 0, 0]}").find("Did you mean 'rpy_deg'?"), std::string::npos);
  EXPECT_NE(pose("0.1").find("is no pose"), std::string::npos);
  EXPECT_NE(pose("{xyz_m: [.nan, 0, 0]}"), "");
}

TEST(LoadFleet, a_file_without_vehicle_or_recording_is_refused_with_a_remedy) {
  EXPECT_NE(error_of("").find("fleet.yaml: no vehicle is named. Write at least"), std::string::npos)
      << error_of("");
  EXPECT_NE(error_of("vehicle: {v1: {recording: a}}").find("Did you mean 'vehicles'?"),
            std::string::npos);
  EXPECT_NE(error_of("vehicles: {v1: {}}").find("vehicles.v1 has no recording"), std::string::npos);
  EXPECT_NE(error_of("vehicles: {v1: }").find("has no recording"), std::string::npos);
  EXPECT_NE(error_of("vehicles: [a]").find("no vehicle is named"), std::string::npos);
  EXPECT_NE(error_of("vehicles: {../x: {recording: a}}").find("no name of a vehicle"),
            std::string::npos);
  EXPECT_NE(error_of("[1, 2]").find("no group of keys"), std::string::npos);
  EXPECT_NE(
      error_of("schema: 2\nvehicles: {v1: {recording: a}}").find("schema is 2. This program reads"),
      std::string::npos);
}

constexpr std::string_view kTwo = "vehicles: {v1: {recording: a}, v2: {recording: b}}\n";

std::string error_of_priors(const std::string& one, const std::string& two) {
  return error_of(std::string(kTwo) + "priors:\n  - " + one + "\n  - " + two + "\n");
}

TEST(LoadFleet, start_pose_priors_of_one_pair_must_agree) {
  const std::string v2 = "{vehicle: v2, relative_to: v1, xyz_m: [-2, 0, 0]}";
  EXPECT_EQ(error_of_priors(v2, "{vehicle: v2, xyz_m: [-2.3, 0.2, 0], yaw_deg: 5}"), "");
  EXPECT_EQ(error_of_priors(v2, "{vehicle: v2, xyz_m: [8, 0, 0]}"),
            "fleet.yaml:3: priors: two of 'v2' relative to 'v1' differ by 10.0 m, 0 deg. Remove "
            "the wrong one, or raise sigma_m and sigma_deg.");
  EXPECT_NE(error_of_priors(v2, "{vehicle: v2, xyz_m: [-2, 0, 0], yaw_deg: 90}").find("90 deg"),
            std::string::npos);
}

TEST(LoadFleet, a_start_pose_prior_in_the_other_direction_is_the_inverse) {
  const std::string v2 = "{vehicle: v2, relative_to: v1, xyz_m: [0, 4, 0], yaw_deg: 90}";
  const std::string right = "{vehicle: v1, relative_to: v2, xyz_m: [-4, 0, 0], yaw_deg: -90}";
  const std::string wrong = "{vehicle: v1, relative_to: v2, xyz_m: [4, 0, 0], yaw_deg: -90}";
  EXPECT_EQ(error_of_priors(v2, right), "");
  EXPECT_NE(error_of_priors(v2, wrong).find("'v1' relative to 'v2' differ by 8.0 m"),
            std::string::npos)
      << error_of_priors(v2, wrong);
}

TEST(LoadFleet, a_start_pose_prior_relative_to_itself_is_refused) {
  EXPECT_NE(error_of(std::string(kTwo) + "priors: [{vehicle: v1}]").find("itself"),
            std::string::npos);
}

// Two vehicles with the same scans would count the same measurements twice.
TEST(LoadFleet, two_vehicles_with_the_same_scans_are_refused) {
  EXPECT_EQ(error_of("vehicles: {v1: {recording: a}, v2: {recording: [b, a]}}"),
            "fleet.yaml:1: /data/run/a is the recording of both 'v1' and 'v2'. Give each its own, "
            "or tell them apart by lidar.topic or by start_s and duration_s.");
  EXPECT_EQ(error_of("vehicles: {v1: {recording: a, lidar: {topic: /1}}, "
                     "v2: {recording: a, lidar: {topic: /2}}}"),
            "");
  EXPECT_EQ(error_of("vehicles: {v1: {recording: a, duration_s: 60}, "
                     "v2: {recording: a, start_s: 60}}"),
            "");
  EXPECT_NE(error_of("vehicles: {v1: {recording: a, duration_s: 60}, "
                     "v2: {recording: a, start_s: 59}}"),
            "");
  EXPECT_EQ(error_of("clock: separate\nvehicles: {v1: {recording: a, duration_s: 60}, "
                     "v2: {recording: a, start_s: 40}}"),
            "");
}

TEST(LoadFleet, preset_paper_requires_a_start_pose_prior_for_every_vehicle) {
  const std::string two = "preset: paper\nvehicles: {v1: {recording: a}, v2: {recording: b}}\n";
  EXPECT_NE(error_of(two).find("priors: none says where 'v2' starts"), std::string::npos);
  EXPECT_EQ(error_of(two + "priors: [{vehicle: v2}]"), "");
}

TEST(LoadFleet, one_recording_under_two_paths_is_recognised_as_the_same) {
  const std::string folder = testing::TempDir() + "shared_recording";
  std::filesystem::create_directories(folder);
  std::ofstream(folder + "/a.mcap") << "x";
  const auto config = parse_fleet(
      "vehicles: {v1: {recording: a.mcap}, v2: {recording: ../shared_recording/a.mcap}}",
      "fleet.yaml", folder, {});
  std::filesystem::remove_all(folder);
  ASSERT_FALSE(config);
  EXPECT_NE(config.error().message().find("recording of both"), std::string::npos);
}

TEST(LoadFleet, antennas_have_non_numeric_names_and_are_at_most_16) {
  const auto with = [](const std::string& antennas) {
    return error_of("vehicles: {v1: {recording: a, antennas: {" + antennas + "}}}");
  };
  std::string many = "a0: {xyz_m: [0, 0, 0]}";
  for (int k = 1; k < 16; ++k) many += ", a" + std::to_string(k) + ": {xyz_m: [0, 0, 0]}";
  EXPECT_EQ(with(many), "");
  EXPECT_EQ(with(many + ", a16: {xyz_m: [0, 0, 0]}"),
            "fleet.yaml:1: vehicles.v1.antennas has 17 antennas; at most 16 are possible.");
  // "1" in ranges.csv would be ambiguous with the second antenna of the list.
  EXPECT_NE(with("1: {xyz_m: [0, 0, 0]}").find("is no name of an antenna"), std::string::npos);
}

TEST(LoadFleet, a_pair_of_vehicles_has_one_range_bias) {
  const std::string two(kTwo);
  EXPECT_EQ(error_of(two + "ranges: {bias_m: {v2-v1: 0.1}}"), "");
  EXPECT_NE(error_of(two + "ranges: {bias_m: {v1-v1: 0.1}}").find("no pair of vehicles"),
            std::string::npos);
  EXPECT_NE(error_of(two + "ranges: {bias_m: {v1-v2: 0.1, v2-v1: 0.3}}").find("the other way"),
            std::string::npos);
}

TEST(LoadFleet, inconsistent_references_and_bounds_are_refused_with_their_line) {
  const std::string v1 = "vehicles: {v1: {recording: a}}\n";
  EXPECT_EQ(error_of(v1 + "priors: [{vehicle: v2}]\n"),
            "fleet.yaml:2: priors: 'v2' is no vehicle (v1). Did you mean 'v1'?");
  EXPECT_NE(error_of(v1 + "priors: [{vehicle: v1, relative_to: v1}]").find("itself"),
            std::string::npos);
  EXPECT_NE(
      error_of(v1 + "ranges: {sources: [{topic: /t, ids: {0: v1/x}}]}").find("no antenna 'x'"),
      std::string::npos);
  EXPECT_NE(error_of(v1 + "ranges: {sources: [{ids: {0: v1}}]}").find("names no sources"),
            std::string::npos);
  EXPECT_NE(error_of(v1 + "ranges: {sources: [{file: a, topic: b}]}").find("names several sources"),
            std::string::npos);
  EXPECT_NE(error_of(v1 + "ranges: {bias_m: {v1-v9: 0.1}}").find("no pair of vehicles"),
            std::string::npos);
  EXPECT_NE(error_of(v1 + "ranges: {limits_m: [3, 2]}").find("the first must be below"),
            std::string::npos);
  EXPECT_NE(error_of("vehicles: {v1: {recording: a, self_box_m: [1, 0, 0, 1, 0, 1]}}")
                .find("xmin is not below xmax"),
            std::string::npos);
  EXPECT_NE(error_of("vehicles: {v1: {recording: a, lidar: {model: vlp17}}}").find("vlp16"),
            std::string::npos);
}

TEST(LoadFleet, the_command_line_overrides_the_file_which_overrides_the_preset) {
  const std::string text = "vehicles: {v1: {recording: a}}\nsettings: {vehicle: {imu_wait_s: 2}}\n";
  Overrides overrides;
  overrides.preset = "paper";
  overrides.assignments = {"vehicle.imu_wait_s=4", "vehicles.v1.lidar.topic=/points",
                           "output.map_voxel_m=0.2"};
  const Result<FleetConfig> config = parse(text, overrides);
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->preset, "paper");
  EXPECT_EQ(config->settings.odometry.preset, odometry::Preset::kPaper);
  EXPECT_EQ(config->settings.vehicle.imu_wait_s, 4.0);
  EXPECT_EQ(config->vehicles[0].lidar.topic, "/points");
  EXPECT_EQ(config->origins.at("preset"), "command line");
  EXPECT_EQ(config->origins.at("settings.odometry.preset"), "preset paper");
  EXPECT_EQ(config->origins.at("settings.vehicle.imu_wait_s"), "command line");
  EXPECT_NE(error_of(text, {"", {"vehicle.imu_wait=3"}}).find("Did you mean 'imu_wait_s'?"),
            std::string::npos);
  EXPECT_NE(error_of(text, {"", {"outptu.map_voxel_m=3"}}).find("Did you mean 'output'?"),
            std::string::npos);
  EXPECT_NE(error_of(text, {"papr", {}}).find("allowed is robust, paper"), std::string::npos);
  EXPECT_NE(error_of(text, {"", {"a: b"}}), "");
  EXPECT_NE(error_of(text, {"", {"preset=papr"}}), "");
}

TEST(LoadFleet, recordings_become_vehicles_named_after_the_files) {
  const Result<FleetConfig> config =
      fleet_of_recordings({"x/v1.mcap", "my run(2).bag", "scans/"}, {});
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->vehicles[0].name, "v1");
  EXPECT_EQ(config->vehicles[1].name, "my_run_2_");
  EXPECT_EQ(config->vehicles[2].name, "scans");
  EXPECT_EQ(config->vehicles[2].recordings.at(0), "scans/");
  const Result<FleetConfig> twins = fleet_of_recordings({"a/v1.bag", "b/v1.bag"}, {});
  ASSERT_FALSE(twins);
  EXPECT_NE(twins.error().message().find("a second recording of the name 'v1'"), std::string::npos);
}

TEST(LoadFleet, calib_yaml_of_a_scan_folder_is_loaded) {
  const auto dir = std::filesystem::temp_directory_path() / "rali_config_calib_test";
  std::filesystem::create_directories(dir);
  std::ofstream(dir / "calib.yaml") << "lidar: {model: rs16}\n";
  const Result<FleetConfig> config = fleet_of_recordings({dir.string()}, {});
  std::ofstream(dir / "calib.yaml") << "lidr: {model: rs16}\n";
  const Result<FleetConfig> wrong = fleet_of_recordings({dir.string()}, {});
  std::filesystem::remove_all(dir);
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->vehicles[0].lidar.cloud.model, "rs16");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message().find("calib.yaml:1: unknown key 'lidr'. Did you mean 'lidar'?"),
            std::string::npos);
}

TEST(LoadFleet, imu_noise_of_the_vehicle_overrides_that_of_the_model) {
  const Result<FleetConfig> config = parse(kComplete);
  ASSERT_TRUE(config);
  const odometry::ImuNoiseSettings noise = imu_noise_of(config->vehicles[0].imu);
  EXPECT_EQ(noise.accel_mps2_rthz, 0.004);                             // vehicle
  EXPECT_EQ(noise.vibration_factor, 5.0);                              // vehicle
  EXPECT_NEAR(noise.gyro_radps_rthz, 0.014 * 3.14159265 / 180, 1e-9);  // BMI088
  const Result<FleetConfig> mti =
      parse("vehicles: {v1: {recording: a, imu: {model: xsens_mti_1}}}");
  ASSERT_TRUE(mti);
  const odometry::ImuNoiseSettings sheet = imu_noise_of(mti->vehicles[0].imu);
  EXPECT_NEAR(sheet.accel_mps2_rthz, 1.18e-3, 1e-5);  // 120 ug
  EXPECT_NEAR(sheet.gyro_radps_rthz, 1.22e-4, 1e-6);  // 0.007 deg/s
}

TEST(LoadFleet, a_pose_is_described_in_words) {
  geometry::SE3 T;
  T.p = geometry::Vec3(0.08, 0.0, 0.25);
  T.R = geometry::rotation_from_rpy(0.0, 0.0, 1.5 * 3.14159265358979 / 180.0);
  EXPECT_EQ(pose_in_words(T),
            "0.08 m forward, 0.25 m up of the body's origin, turned 1.5 deg left");
  EXPECT_EQ(pose_in_words({}), "at the origin of the body, not turned");
}

TEST(LoadFleet, a_truncated_file_loads_or_gives_an_error_with_its_name) {
  for (std::size_t n = 0; n < kComplete.size(); n += 3) {
    const Result<FleetConfig> config = parse(kComplete.substr(0, n));
    if (!config) {
      EXPECT_EQ(config.error().message().substr(0, 10), "fleet.yaml");
    }
  }
}

TEST(LoadFleet, the_settings_manual_in_docs_matches_the_program) {
  std::ifstream file(std::string(RALI_SOURCE_DIR) + "/docs/reference/settings.md");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  EXPECT_TRUE(text == settings_manual(SettingsShown::kPublic))
      << "docs/reference/settings.md is not that of the program; renew it with: make docs";
}

}  // namespace
}  // namespace rali::config
