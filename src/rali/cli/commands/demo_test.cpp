#include "rali/cli/commands/demo.hpp"

#include <cstdio>

#include <gtest/gtest.h>

#include "rali/cli/app.hpp"
#include "rali/cli/command.hpp"
#include "rali/cli/run_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

Outcome short_demo(const std::string& folder) {
  return run_rali(
      {"demo", "-o", folder, "--duration", "1.5", "--pedestrians", "0", "--threads", "1"});
}

TEST(Demo, writes_recording_both_results_reports_and_picture) {
  const io::TestFolder folder;
  const std::string demo = folder.path("d");
  const Outcome run = short_demo(demo);
  // Such a short drive may not constrain the relative pose of the vehicles.
  ASSERT_TRUE(run.code == kExitDone || run.code == kExitGaps) << run.err;
  EXPECT_TRUE(run.out.starts_with("without ranges:\n" + demo + "/alone/report.html\n2 vehicles"))
      << run.out;
  EXPECT_NE(run.out.find("with ranges:\n" + demo + "/out/report.html\n2 vehicles"),
            std::string::npos)
      << run.out;
  EXPECT_TRUE(run.out.ends_with(demo + "/map.png\n")) << run.out;
  // So early, only the start pose (sigma 0.28 m) connects the two vehicles.
  EXPECT_NE(run.out.find("placed by the prior"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("against the truth: position off by 0."), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("next: "), std::string::npos) << "that follows by itself";
  EXPECT_NE(run.err.find("$ rali simulate " + demo + "/tunnel.yaml"), std::string::npos) << run.err;
  for (const char* name :
       {"tunnel.yaml", "recording/v2.mcap", "recording/fleet.yaml", "recording/truth/v2.tum",
        "recording/truth/mesh.ply", "out/evaluation.json", "out/errors/v2.csv",
        "out/trajectory/v2.tum", "alone/trajectory/v2.tum", "map.png"}) {
    EXPECT_FALSE(folder.read(std::string("d/") + name).empty()) << name;
  }
  const std::string report = folder.read("d/out/report.html");
  EXPECT_NE(report.find("Map to the true surface: mean"), std::string::npos) << "truth section";
  EXPECT_NE(folder.read("d/out/status.json").find("\"report.html\""), std::string::npos);
}

TEST(Demo, of_a_scene_other_than_the_default_maps_it_once) {
  const io::TestFolder folder;
  const std::string demo = folder.path("d");
  const Outcome run = run_rali({"demo", "-o", demo, "--scene", "loop", "--duration", "1.5",
                                "--pedestrians", "1", "--threads", "1"});
  ASSERT_EQ(run.code, kExitDone) << run.err;
  EXPECT_TRUE(run.out.starts_with(demo + "/out/report.html\n1 vehicle\n")) << run.out;
  EXPECT_NE(run.err.find("$ rali simulate loop -o " + demo), std::string::npos) << run.err;
  EXPECT_FALSE(folder.read("d/map.png").empty());
}

TEST(Demo, can_be_repeated_in_the_same_folder) {
  const io::TestFolder folder;
  const int code = short_demo(folder.path("d")).code;
  const std::string first = folder.read("d/out/trajectory/v2.tum");
  EXPECT_FALSE(first.empty());
  ASSERT_EQ(short_demo(folder.path("d")).code, code);
  EXPECT_EQ(first, folder.read("d/out/trajectory/v2.tum"));
}

TEST(Demo, does_not_change_a_folder_that_it_did_not_create) {
  const io::TestFolder folder;
  std::filesystem::create_directories(folder.path("d/recording"));
  const std::string mine = folder.write("d/recording/v1.mcap", "mine");
  const Outcome run = short_demo(folder.path("d"));
  EXPECT_EQ(run.code, kExitNotStarted) << run.err;
  EXPECT_EQ(folder.read("d/recording/v1.mcap"), "mine");
}

TEST(Demo, refuses_invalid_numbers) {
  const io::TestFolder folder;
  for (const char* option : {"--seed", "--duration", "--pedestrians", "--threads"}) {
    for (const char* value : {"-1", "nan", "many"}) {
      const Outcome run = run_rali({"demo", "-o", folder.path("d"), option, value});
      EXPECT_EQ(run.code, kExitNotStarted) << option << ' ' << value << '\n' << run.err;
      EXPECT_NE(run.err.find("rali: error: "), std::string::npos) << option << ' ' << value;
    }
  }
  EXPECT_EQ(folder.files(), 0U);
}

TEST(MapWithTruth, reports_ground_truth_without_common_time_and_keeps_the_map) {
  const io::TestFolder folder;
  ASSERT_EQ(run_rali({"simulate", "loop", "-o", folder.path("s"), "--duration", "1", "-q"}).code,
            0);
  folder.write("s/truth/v1.tum", "10 0 0 0 0 0 0 1\n11 1 0 0 0 0 0 1\n12 2 0 0 0 0 0 1\n");
  const std::vector<std::string> words{
      "map", folder.path("s/fleet.yaml"), "-o", folder.path("o"), "--threads", "1", "--truth"};
  std::vector<std::string> with_truth = words;
  with_truth.push_back(folder.path("s/truth"));
  const Outcome run = run_rali(with_truth);
  EXPECT_EQ(run.code, kExitBelowAsked) << run.err;
  EXPECT_NE(run.err.find("no pose has a truth at its time"), std::string::npos) << run.err;
  EXPECT_TRUE(run.out.starts_with(folder.path("o/report.html") + '\n')) << run.out;
  EXPECT_FALSE(folder.read("o/map.pcd").empty());
  std::vector<std::string> without = words;
  without[3] = folder.path("o2");
  without.push_back(folder.path("nowhere"));
  EXPECT_EQ(run_rali(without).code, kExitNotStarted);
  EXPECT_FALSE(std::filesystem::exists(folder.path("o2")));
}

TEST(EvaluateRun, updates_the_report_of_the_run) {
  const io::TestFolder folder;
  ASSERT_EQ(run_rali({"simulate", "loop", "-o", folder.path("s"), "--duration", "1", "-q"}).code,
            0);
  ASSERT_EQ(run_rali({"map", folder.path("s/fleet.yaml"), "-o", folder.path("o"), "-q"}).code, 0);
  const std::string before = folder.read("o/report.html");
  ASSERT_EQ(run_rali({"evaluate", folder.path("o"), "--truth", folder.path("s/truth"), "-q"}).code,
            0);
  const std::string after = folder.read("o/report.html");
  EXPECT_NE(after.find("Map to the true surface: mean"), std::string::npos);
  EXPECT_EQ(before.find("Map to the true surface: mean"), std::string::npos);
}

}  // namespace
}  // namespace rali::cli
