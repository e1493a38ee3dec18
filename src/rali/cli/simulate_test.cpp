#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "rali/cli/app.hpp"
#include "rali/cli/closed_loop_job.hpp"
#include "rali/cli/run_for_test.hpp"
#include "rali/config/load_fleet.hpp"

namespace rali::cli {
namespace {

namespace fs = std::filesystem;

Outcome simulate(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "simulate");
  return run_rali(arguments);
}

/// A temporary folder that is deleted afterwards.
class Simulate : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    // Includes the process id: two parallel runs of this program must not delete each other's
    // folder.
    folder_ =
        (fs::temp_directory_path() / fmt::format("rali_simulate_{}_{}", test->name(), ::getpid()))
            .string();
    fs::remove_all(folder_);
  }

  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string bytes(const std::string& name) const {
    std::ifstream file(folder_ + "/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  std::string folder_;
};

TEST_F(Simulate, writes_a_loadable_recording_and_prints_a_summary) {
  const Outcome done = simulate({"corridor", "-o", folder_, "--duration", "0.3", "-q"});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_NE(done.out.find("corridor, seed 1: 2 vehicles, 0.3 s of data"), std::string::npos)
      << done.out;
  const auto fleet = config::load_fleet(folder_ + "/fleet.yaml", {});
  ASSERT_TRUE(fleet.has_value()) << fleet.error().message();
  EXPECT_EQ(fleet->vehicles.size(), 2U);
  EXPECT_TRUE(fs::exists(folder_ + "/truth/mesh.ply"));
}

TEST_F(Simulate, warns_of_an_old_setting_with_its_new_name) {
  // The invalid thread count ends it before anything is simulated.
  const Outcome refused = simulate({"corridor", "-o", folder_, "--closed-loop", "--set",
                                    "settings.mission.place_m=3", "--threads", "-1"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("rali: warning: command line: settings.mission.place_m is called "
                             "settings.mission.progress_m now."),
            std::string::npos)
      << refused.err;
}

TEST_F(Simulate, a_single_vehicle_has_no_antennas_in_fleet_yaml) {
  ASSERT_EQ(simulate({"tunnel", "-o", folder_, "--vehicles", "1", "--duration", "0.2", "-q"}).code,
            0);
  EXPECT_EQ(bytes("fleet.yaml").find("antennas"), std::string::npos) << bytes("fleet.yaml");
}

TEST_F(Simulate, an_old_key_of_the_scene_is_read_with_a_notice) {
  const Outcome done =
      simulate({"tunnel", "-o", folder_, "--duration", "0.2", "-q", "--set", "motion.rest_s=2"});
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_NE(bytes("scene.yaml").find("  standstill_s: 2"), std::string::npos);
  const Outcome loud =
      simulate({"tunnel", "-o", folder_ + "/b", "--duration", "0.2", "--set", "motion.rest_s=1"});
  EXPECT_NE(loud.err.find("rali: warning: command line: motion.rest_s is called "
                          "motion.standstill_s now."),
            std::string::npos)
      << loud.err;
}

TEST_F(Simulate, its_scene_yaml_reproduces_the_same_recording) {
  ASSERT_EQ(simulate({"tunnel", "-o", folder_, "--duration", "0.2", "--seed", "3", "-q"}).code, 0);
  const std::string first = bytes("v1.mcap");
  const std::string again = folder_ + "/again";
  const Outcome done = simulate({folder_ + "/scene.yaml", "-o", again, "-q", "--threads", "2"});
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_FALSE(first.empty());
  EXPECT_EQ(bytes("again/v1.mcap") == first, true) << "another recording";
}

TEST_F(Simulate, json_output_is_one_document_equal_to_simulation_json) {
  const Outcome done =
      simulate({"hall", "-o", folder_, "--duration", "0.2", "--json", "--progress", "off"});
  ASSERT_EQ(done.code, 0) << done.err;
  const auto document = nlohmann::json::parse(done.out, nullptr, false);
  ASSERT_TRUE(document.is_object()) << done.out;
  EXPECT_EQ(document["status"], "complete");
  EXPECT_EQ(done.out, bytes("simulation.json"));
}

TEST_F(Simulate, a_closed_loop_ended_by_its_duration_keeps_the_recording) {
  const Outcome ended = simulate({"corridor", "-o", folder_, "--closed-loop", "--vehicles", "2",
                                  "--duration", "3", "--set", "link.loss=0.1", "--set",
                                  "settings.mission.roles.lease_s=4", "--set", "sim.cpu_factor=3"});
  EXPECT_EQ(ended.code, 1) << ended.err;
  for (const char* name : {"v1.mcap", "v2.mcap", "ranges.csv", "fleet.yaml", "rounds.csv",
                           "frontiers.csv", "traffic.csv", "truth/v2.tum"}) {
    EXPECT_TRUE(fs::exists(fs::path(folder_) / name)) << name;
  }
  const std::string traffic = bytes("traffic.csv");
  EXPECT_TRUE(traffic.starts_with("vehicle,kind,messages,bytes,mb_per_min\n")) << traffic;
  EXPECT_NE(traffic.find("v2,peer,"), std::string::npos) << traffic;
  EXPECT_NE(ended.out.find("MB per minute and vehicle"), std::string::npos) << ended.out;
}

TEST_F(Simulate, faults_reach_the_vehicles_of_a_closed_loop) {
  const auto traffic_with = [&](const std::vector<std::string>& fault) {
    std::vector<std::string> arguments = {"corridor",   "-o",    folder_,        "--overwrite",
                                          "--vehicles", "2",     "--duration",   "4",
                                          "--lidar",    "vlp16", "--closed-loop"};
    arguments.insert(arguments.end(), fault.begin(), fault.end());
    const Outcome ended = simulate(arguments);
    EXPECT_EQ(ended.code, 1) << ended.err;
    return bytes("traffic.csv");
  };
  const auto has = [](const std::string& text, const char* row) {
    return text.find(row) != std::string::npos;
  };
  const std::string intact = traffic_with({});
  EXPECT_TRUE(has(intact, "v1,points,") && has(intact, "v2,points,")) << intact;
  const std::string gap = traffic_with({"--fault", "gap:v1@0-9"});
  EXPECT_TRUE(!has(gap, "v1,points,") && has(gap, "v2,points,")) << "v1 saw nothing\n" << gap;
  const std::string loss = traffic_with({"--fault", "radio_loss:v2@0-9"});
  EXPECT_TRUE(!has(loss, "v1,points,") && !has(loss, "v2,points,")) << "nobody asked\n" << loss;
}

TEST(MissionText, of_a_stopped_mission_gives_the_reason) {
  drive::MissionLog mission;
  mission.ended = true;
  mission.rounds.resize(2);
  fleet::FrontierRow row;
  row.reason = "3 m2 unknown behind it";
  row.round = 1;
  mission.frontiers.push_back(row);
  row.round = 2;
  row.reason = "another vehicle blocks every path to it";
  mission.frontiers.push_back(row);
  mission.frontiers.push_back(row);
  const std::string text = mission_text(mission, 60.0);
  EXPECT_NE(text.find("no vehicle could reach more: 2 frontiers are left"), std::string::npos)
      << text;
  EXPECT_NE(text.find("  2 of them: another vehicle blocks every path to it\n"), std::string::npos)
      << text;
  EXPECT_EQ(text.find("unknown behind"), std::string::npos) << text;
}

TEST_F(Simulate, invalid_arguments_exit_with_2_before_anything_is_written) {
  const std::vector<std::vector<std::string>> wrong = {
      {"lopp", "-o", folder_},
      {"loop"},
      {"loop", "-o", folder_, "--vehicles", "11"},
      {"loop", "-o", folder_, "--vehicles", "0"},
      {"loop", "-o", folder_, "--seed", "-1"},
      {"loop", "-o", folder_, "--seed", "1.5"},
      {"loop", "-o", folder_, "--duration", "nan"},
      {"loop", "-o", folder_, "--duration", "-3"},
      {"loop", "-o", folder_, "--pedestrians", "many"},
      {"loop", "-o", folder_, "--lidar", "rs17"},
      {"loop", "-o", folder_, "--format", "pcap"},
      {"loop", "-o", folder_, "--fault", "gap:v2@1-2"},
      {"loop", "-o", folder_, "--fault", "gap"},
      {"loop", "-o", folder_, "--live", "--fault", "radio_loss:v1@1-2"},
      {"loop", "-o", folder_, "--set", "uwb.sigma=3"},
      {"loop", "-o", folder_, "--set", "uwb.sigma_m=-3"},
      {"loop", "-o", folder_, "--set", "link.loss=0.1"},
      {"corridor", "-o", folder_, "--closed-loop", "--set", "link.loss=1.1"},
      {"corridor", "-o", folder_, "--closed-loop", "--set", "link.los=0.1"},
      {"loop", "-o", folder_, "--set", "sim.cpu_factor=2"},
      {"corridor", "-o", folder_, "--closed-loop", "--set", "sim.cpu_factor=-1"},
      {"corridor", "-o", folder_, "--closed-loop", "--set", "settings.mission.roles.leas_s=1"},
      {"corridor", "-o", folder_, "--closed-loop", "--set", "settings.mission.progress_m=-1"},
      {"loop", "-o", folder_, "--threads", "-1"},
      {"/nowhere/scene.yaml", "-o", folder_},
  };
  for (const auto& arguments : wrong) {
    const Outcome refused = simulate(arguments);
    EXPECT_EQ(refused.code, 2) << arguments.back();
    EXPECT_EQ(refused.err.substr(0, 13), "rali: error: ") << arguments.back();
    EXPECT_EQ(refused.out, "") << arguments.back();
    EXPECT_FALSE(fs::exists(folder_)) << arguments.back();
  }
}

TEST_F(Simulate, overwrites_existing_files_only_with_overwrite) {
  const std::vector<std::string> arguments{"yard", "-o", folder_, "--duration", "0.2", "-q"};
  ASSERT_EQ(simulate(arguments).code, 0);
  const Outcome refused = simulate(arguments);
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("is not empty"), std::string::npos);
  std::vector<std::string> again = arguments;
  again.emplace_back("--overwrite");
  EXPECT_EQ(simulate(again).code, 0);
}

}  // namespace
}  // namespace rali::cli
