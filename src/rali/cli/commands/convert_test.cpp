#include <gtest/gtest.h>

#include "rali/cli/run_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

constexpr const char* kTum = "1.0 1 2 3 0 0 0 1\n2.0 2 2 3 0 0 0 1\n";

TEST(ConvertCommand, refuses_to_overwrite_unless_asked) {
  const io::TestFolder folder;
  const std::string in = folder.write("a.tum", kTum);
  const std::string out = folder.write("b.kitti", "mine");
  const Outcome refused = run_rali({"convert", in, out});
  EXPECT_EQ(refused.code, kExitNotStarted);
  EXPECT_EQ(refused.err,
            "rali: error: " + out + ": exists. Choose another name, or --overwrite.\n");
  EXPECT_EQ(folder.read("b.kitti"), "mine");
  const Outcome done = run_rali({"convert", in, out, "--overwrite"});
  EXPECT_EQ(done.code, kExitDone) << done.err;
  EXPECT_EQ(done.out, out + ": 2 poses\n");
  EXPECT_EQ(done.err, "not in " + out + ": stamps: KITTI has none\n");
  EXPECT_NE(folder.read("b.kitti"), "mine");
}

TEST(ConvertCommand, refuses_one_file_as_input_and_output) {
  const io::TestFolder folder;
  const std::string in = folder.write("a.tum", kTum);
  const Outcome refused = run_rali({"convert", in, in, "--overwrite"});
  EXPECT_EQ(refused.code, kExitNotStarted);
  EXPECT_NE(refused.err.find("input and output at once"), std::string::npos);
  EXPECT_EQ(folder.read("a.tum"), kTum);
}

TEST(ConvertCommand, needs_input_and_output) {
  EXPECT_EQ(run_rali({"convert", "a.tum"}).code, kExitNotStarted);
}

}  // namespace
}  // namespace rali::cli
