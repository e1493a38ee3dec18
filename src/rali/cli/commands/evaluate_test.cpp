#include <filesystem>

#include <gtest/gtest.h>

#include "rali/cli/app.hpp"
#include "rali/cli/command.hpp"
#include "rali/cli/run_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

/// Three sides of a square, 0.1 m a step; the estimate's corner is `bump_m` too high.
std::string path(double bump_m, double start_s = 100.0) {
  std::string text;
  for (int i = 0; i < 300; ++i) {
    const double x = i < 100 ? 0.1 * i : (i < 200 ? 10.0 : 0.1 * (300 - i));
    const double y = i < 100 ? 0.0 : (i < 200 ? 0.1 * (i - 100) : 10.0);
    text += std::to_string(start_s + 0.02 * i) + ' ' + std::to_string(x) + ' ' + std::to_string(y) +
            ' ' + std::to_string(i == 100 ? bump_m : 0.0) + " 0 0 0 1\n";
  }
  return text;
}

Outcome evaluate(std::vector<std::string> words) {
  words.insert(words.begin(), "evaluate");
  return run_rali(words);
}

TEST(Evaluate, two_trajectories_give_a_table_and_exit_code_0) {
  const io::TestFolder f;
  const Outcome run = evaluate({f.write("est.tum", path(0.3)), f.write("ref.tum", path(0.0))});
  EXPECT_EQ(run.code, kExitDone) << run.err;
  EXPECT_NE(run.out.find("APE, rmse [m]"), std::string::npos);
  EXPECT_EQ(f.files(), 2U);  // nothing is written next to the input
}

TEST(Evaluate, a_violated_limit_is_named_and_gives_exit_code_1) {
  const io::TestFolder f;
  const std::string est = f.write("est.tum", path(0.3)), ref = f.write("ref.tum", path(0.0));
  EXPECT_EQ(evaluate({est, ref, "--limit", "ape_max_m=0.5"}).code, kExitDone);
  const Outcome run =
      evaluate({est, ref, "--limit", "ape_max_m=0.1", "--limit", "est:ape_rmse_m=1"});
  EXPECT_EQ(run.code, kExitBelowAsked);
  EXPECT_NE(run.err.find("limit ape_max_m=0.1: it is 0.29"), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("est:ape_rmse_m"), std::string::npos);
}

TEST(Evaluate, a_limit_with_an_old_name_is_checked_with_a_notice) {
  const io::TestFolder f;
  const std::string est = f.write("est.tum", path(0.0));
  const Outcome run = evaluate({est, est, "--limit", "along_blind_rmse_m=1"});
  EXPECT_NE(run.err.find("the name is now along_degenerate_rmse_m."), std::string::npos) << run.err;
}

TEST(Evaluate, writes_its_files_into_the_folder_and_prints_one_json_document) {
  const io::TestFolder f;
  std::filesystem::create_directories(f.path("out/trajectory"));
  std::filesystem::create_directories(f.path("truth"));
  f.write("out/trajectory/v1.tum", path(0.1));
  f.write("truth/v1.tum", path(0.0));
  const Outcome run = evaluate({f.path("out") + "/", "--truth", f.path("truth"), "--json", "-q"});
  EXPECT_EQ(run.code, kExitDone) << run.err;
  EXPECT_EQ(run.out, f.read("out/evaluation.json"));
  EXPECT_TRUE(f.read("out/errors/v1.csv").starts_with("stamp_s,ape_m"));
}

TEST(Evaluate, invalid_input_and_options_give_exit_code_2) {
  const io::TestFolder f;
  const std::string est = f.write("est.tum", path(0.0)),
                    late = f.write("late.tum", path(0.0, 4000));
  const Outcome run = evaluate({est, late});
  EXPECT_EQ(run.code, kExitNotStarted);
  EXPECT_NE(run.err.find("100.000 .. 105.980 s against 4000.000 .. 4005.980 s"), std::string::npos)
      << run.err;
  EXPECT_EQ(evaluate({est}).code, kExitNotStarted);
  EXPECT_EQ(evaluate({est, est, "--truth", est}).code, kExitNotStarted);
  EXPECT_EQ(evaluate({est, est, "--limit", "nonsense=1"}).code, kExitNotStarted);
  EXPECT_EQ(evaluate({est, est, "--delta", "0"}).code, kExitNotStarted);
  EXPECT_EQ(evaluate({est, est, "--align", "sim3"}).code, kExitNotStarted);
  EXPECT_EQ(evaluate({f.write("empty.tum", ""), est}).code, kExitNotStarted);
  EXPECT_EQ(evaluate({f.path("none.tum"), est}).code, kExitNotStarted);
}

}  // namespace
}  // namespace rali::cli
