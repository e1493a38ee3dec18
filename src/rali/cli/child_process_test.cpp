#include "rali/cli/child_process.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

namespace rali::cli {
namespace {

// In a test /proc/self/exe is the test program, so gtest's own options are used.

std::string log_file(const char* name) { return testing::TempDir() + name; }

TEST(ChildProcess, writes_its_output_to_the_log_and_returns_its_exit_code) {
  auto child = ChildProcess::start({"--gtest_list_tests", "--gtest_filter=ChildProcess.*"},
                                   log_file("child_list.log"));
  ASSERT_TRUE(child) << child.error().message();
  EXPECT_EQ(child->wait(60.0), 0);
  EXPECT_EQ(child->ended(), 0);
  EXPECT_NE(last_lines(child->log(), 100).find("writes_its_output_to_the_log"), std::string::npos);
}

TEST(ChildProcess, with_an_unwritable_log_is_an_error) {
  auto child = ChildProcess::start({"--gtest_list_tests"}, "/no/such/folder/child.log");
  // The spawn itself may succeed; then the child ends at once, with an error.
  if (child) {
    EXPECT_NE(child->wait(60.0), 0);
  } else {
    EXPECT_EQ(child.error().code, ErrorCode::kMachine);
  }
}

TEST(ChildProcess, stops_on_request_with_sigint) {
  std::optional<ChildProcess> child;
  {
    auto started = ChildProcess::start(
        {"--gtest_also_run_disabled_tests", "--gtest_filter=*DISABLED_waits_for_60_s"},
        log_file("child_wait.log"));
    ASSERT_TRUE(started);
    child.emplace(std::move(*started));
  }
  EXPECT_FALSE(child->ended());
  child->ask_to_end();
  EXPECT_EQ(child->wait(30.0), 128 + 2) << "by SIGINT";
}

TEST(ChildProcess, DISABLED_waits_for_60_s) {
  for (int i = 0; i < 600; ++i) usleep(100'000);
}

TEST(LastLines, of_a_missing_file_are_empty) { EXPECT_EQ(last_lines("/no/such/file", 3), ""); }

}  // namespace
}  // namespace rali::cli
