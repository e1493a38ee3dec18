#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "rali/report/internal/test_run.hpp"
#include "rali/report/read_run.hpp"
#include "rali/report/report.hpp"
#include "rali/report/thinned_map.hpp"

namespace rali::report {
namespace {

constexpr std::size_t kPageBytesMax = 10'000'000;

/// Runs of the short suite, or as set by RALI_FUZZ_RUNS.
std::size_t runs_asked() {
  const char* text = std::getenv("RALI_FUZZ_RUNS");
  return text != nullptr ? static_cast<std::size_t>(std::strtoul(text, nullptr, 10)) : 42;
}

/// One damage, determined by `seed` alone: bytes replaced, removed, duplicated, or harmful words.
std::string damaged(std::string text, std::uint64_t seed) {
  const auto pick = [&](std::uint64_t n) { return n == 0 ? 0 : (seed = mixed(seed)) % n; };
  const std::vector<std::string> words = {"nan",
                                          "-inf",
                                          "1e308",
                                          "-1",
                                          "4294967295",
                                          "99999999999999999999",
                                          "",
                                          ",",
                                          "\n",
                                          "{",
                                          "[[[[",
                                          "\"",
                                          "<script>",
                                          "0",
                                          "\xFF\xFE",
                                          std::string(1, '\0'),
                                          "-9223372036854775808"};
  for (std::uint64_t i = 0, n = 1 + pick(4); i < n; ++i) {
    const std::size_t at = static_cast<std::size_t>(pick(text.size() + 1));
    switch (pick(5)) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(pick(256));
        break;
      case 1:
        text.erase(at, static_cast<std::size_t>(pick(40)));
        break;
      case 2:
        text.insert(at, words[static_cast<std::size_t>(pick(words.size()))]);
        break;
      case 3: {  // a number or word replaced
        const std::size_t end = std::min(text.find_first_of(",\n:} ", at), text.size());
        text.replace(at, end - at, words[static_cast<std::size_t>(pick(words.size()))]);
        break;
      }
      default:
        text.insert(at, text.substr(at, static_cast<std::size_t>(pick(200))));
    }
  }
  return text;
}

TEST(HostileFolder, gives_a_page_or_an_error_for_any_file_contents) {
  const io::TestFolder folder;
  TestRun run;
  run.vehicles = {"v1", "v2"};
  run.fleet = run.truth = true;
  run.poses = 12;
  run.points = 60;
  write_test_run(folder, run);
  const std::vector<std::string> names = {"metrics.json",
                                          "evaluation.json",
                                          "status.json",
                                          "timing.json",
                                          "settings.yaml",
                                          "trajectory/v1.tum",
                                          "trajectory/v2.cov.csv",
                                          "degeneracy/v2.csv",
                                          "errors/v1.csv",
                                          "ranges.csv",
                                          "rounds.csv",
                                          "frontiers.csv",
                                          "loops.csv",
                                          "map.pcd"};
  std::vector<std::string> whole;
  for (const std::string& name : names) whole.push_back(folder.read(name));
  const std::size_t runs = runs_asked();
  for (std::size_t seed = 0; seed < runs; ++seed) {
    const std::size_t file = seed % names.size();
    folder.write(names[file], damaged(whole[file], seed));
    const Result<RunData> read = read_run(folder.path());
    ASSERT_TRUE(read) << names[file] << ", seed " << seed;
    const std::string page = report_html(*read);
    ASSERT_GT(page.size(), 1000U) << names[file] << ", seed " << seed;
    ASSERT_LT(page.size(), kPageBytesMax) << names[file] << ", seed " << seed;
    ASSERT_EQ(page.substr(page.size() - 8), "</html>\n");
    if (seed % 10 == 0) {
      ASSERT_GT(comparison_html({*read, *read}).size(), 1000U);
    }
    folder.write(names[file], whole[file]);
  }
}

TEST(HostileFolder, with_folders_and_empty_files_instead_of_files_gives_a_page) {
  const io::TestFolder folder;
  write_test_run(folder, TestRun{});
  for (const char* name : {"map.pcd", "settings.yaml", "timing.json", "ranges.csv"}) {
    std::filesystem::remove(folder.path(name));
    std::filesystem::create_directory(folder.path(name));
  }
  folder.write("trajectory/v1.tum", "");
  folder.write("degeneracy/v1.csv", "");
  folder.write("evaluation.json", "");
  const Result<RunData> read = read_run(folder.path());
  ASSERT_TRUE(read);
  EXPECT_GT(report_html(*read).size(), 1000U);
}

TEST(HostileFolder, with_json_nested_20000_deep_gives_a_page) {
  const io::TestFolder folder;
  write_test_run(folder, TestRun{});
  folder.write("evaluation.json",
               "{\"a\":" + std::string(20'000, '[') + std::string(20'000, ']') + "}");
  const Result<RunData> read = read_run(folder.path());
  ASSERT_TRUE(read);
  EXPECT_GT(report_html(*read).size(), 1000U);
}

}  // namespace
}  // namespace rali::report
