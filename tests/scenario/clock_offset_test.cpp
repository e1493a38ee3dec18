// Two vehicles whose clocks differ by a second: `clock: offset` finds it.

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/cli/run_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

class ClockOffset : public testing::Test {
 protected:
  /// v2's clock is a second ahead; recorded once for all tests.
  static void SetUpTestSuite() {
    sim_ = new io::TestFolder();
    const Outcome done =
        run_rali({"simulate", "floor", "-o", sim_->path("sim"), "--vehicles", "2", "--duration",
                  "75", "--seed", "5", "--fault", "clock_jump:v2@0-36000", "-q"});
    ASSERT_EQ(done.code, kExitDone) << done.err;
  }

  static void TearDownTestSuite() { delete sim_; }

  [[nodiscard]] static Outcome map(const std::vector<std::string>& more) {
    std::vector<std::string> words = {"map",       sim_->path("sim/fleet.yaml"),
                                      "-o",        sim_->path("out"),
                                      "-q",        "--overwrite",
                                      "--no-mcap", "--no-report",
                                      "--formats", "ply"};
    words.insert(words.end(), more.begin(), more.end());
    return run_rali(words);
  }

  [[nodiscard]] static nlohmann::json metrics() {
    return nlohmann::json::parse(sim_->read("out/metrics.json"));
  }

  [[nodiscard]] static bool run_log_has(const std::string& words) {
    return sim_->read("out/run.log").find(words) != std::string::npos;
  }

  static io::TestFolder* sim_;
};

io::TestFolder* ClockOffset::sim_ = nullptr;

TEST_F(ClockOffset, is_found_from_motion_and_ranges) {
  const Outcome run = map({"--set", "clock=offset"});
  ASSERT_EQ(run.code, kExitDone) << run.err;
  const nlohmann::json vehicles = metrics()["vehicles"];
  EXPECT_EQ(vehicles["v1"]["clock_offset_s"], 0.0) << "the clock of the fleet";
  const double offset_s = vehicles["v2"]["clock_offset_s"];
  const double sigma_s = vehicles["v2"]["clock_offset_sigma_s"];
  EXPECT_LE(sigma_s, 0.05);
  EXPECT_NEAR(offset_s, -1.0, 4.0 * sigma_s);
  EXPECT_TRUE(run_log_has("added to get the clock of v1"));
  const std::string settings = sim_->read("out/settings.yaml");
  EXPECT_NE(settings.find("clock_offset_s: -"), std::string::npos) << "a rerun needs no search";
}

TEST_F(ClockOffset, that_nobody_has_stated_is_reported) {
  const Outcome run = map({});
  ASSERT_EQ(run.code, kExitDone) << run.err;
  EXPECT_TRUE(run_log_has("ahead of that of v1")) << sim_->read("out/run.log");
  EXPECT_EQ(metrics()["vehicles"]["v2"]["clock_offset_s"], 0.0);
}

TEST_F(ClockOffset, that_is_given_is_added_to_all_stamps_without_a_search) {
  const Outcome run = map({"--set", "clock=offset", "--set", "vehicles.v2.clock_offset_s=-1"});
  ASSERT_EQ(run.code, kExitDone) << run.err;
  EXPECT_EQ(metrics()["vehicles"]["v2"]["clock_offset_s"], -1.0);
  EXPECT_TRUE(metrics()["vehicles"]["v2"]["clock_offset_sigma_s"].is_null());
  EXPECT_FALSE(run_log_has("D17")) << "neither a search nor a contradiction";
  const auto stages = nlohmann::json::parse(sim_->read("out/timing.json"))["stages_s"];
  EXPECT_FALSE(stages.contains("clock offset")) << "no pass before the run";
  EXPECT_TRUE(stages.contains("clock check"));
  const Outcome judged =
      run_rali({"evaluate", sim_->path("out"), "--truth", sim_->path("sim/truth"), "-q"});
  EXPECT_EQ(judged.code, kExitDone) << judged.err;
  EXPECT_EQ(judged.err.find("stamps"), std::string::npos) << "v2 on the true clock\n" << judged.err;
}

}  // namespace
}  // namespace rali::cli
