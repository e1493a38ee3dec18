#include "rali/report/report.hpp"

#include <fstream>

#include <gtest/gtest.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/internal/read_parts.hpp"
#include "rali/report/internal/test_run.hpp"
#include "rali/report/read_run.hpp"

namespace rali::report {
namespace {

constexpr std::size_t kPageBytesMax = 10'000'000;

std::string page_of(const io::TestFolder& folder) {
  const Result<RunData> run = read_run(folder.path());
  EXPECT_TRUE(run) << run.error().message();
  return run ? report_html(*run) : std::string();
}

std::string page_of(const TestRun& run) {
  const io::TestFolder folder;
  write_test_run(folder, run);
  return page_of(folder);
}

bool has(const std::string& page, std::string_view text) {
  return page.find(text) != std::string::npos;
}

/// The page without its scripts and pictures, which may contain any bytes.
std::string without_bulk(std::string page) {
  const std::size_t script = page.rfind("<script>");
  if (script != std::string::npos) page.resize(script);
  const std::string_view data = "<script type=\"application/json\" id=\"page-data\">";
  const std::size_t begin = page.find(data);
  if (begin == std::string::npos) return page;
  // The data end with the first "</script>", as browsers parse it.
  const std::size_t end = page.find("</script>", begin);
  return page.erase(begin, end - begin);
}

std::size_t count(const std::string& page, std::string_view text) {
  std::size_t n = 0;
  for (std::size_t at = page.find(text); at != std::string::npos; at = page.find(text, at + 1)) ++n;
  return n;
}

TEST(Report, shows_the_numbers_of_metrics_json) {
  const std::string page = page_of(TestRun{});
  for (const char* number : {"24.1 m", "0.094 m", "0.041 m", "1.2 ms", "<td>31</td>", "0.007 m"}) {
    EXPECT_TRUE(has(page, number)) << number;
  }
}

TEST(Report, rates_nothing_unchecked_as_good) {
  const io::TestFolder folder;
  folder.write("metrics.json", R"({"vehicles":{"v1":{}}})");
  const std::string page = page_of(folder);
  EXPECT_FALSE(has(page, "state good"));
  EXPECT_EQ(count(page, "class=\"state none\""), 9U);
}

TEST(Report, names_the_largest_uncertainty_of_a_run) {
  EXPECT_TRUE(has(
      page_of(TestRun{}),
      "Largest uncertainty:</b> the position of v1, 0.094 m (1 sigma). Nothing here was measured"));
  TestRun warned;
  warned.warning = "the gyro turned 2.10 times as much as the LiDAR";
  EXPECT_TRUE(has(page_of(warned), "Largest uncertainty:</b> the gyro turned 2.10"));
  TestRun stopped;
  stopped.status = "interrupted";
  EXPECT_TRUE(has(page_of(stopped), "Largest uncertainty:</b> the run was stopped at 20 s"));
}

TEST(Report, shows_ground_truth_if_available) {
  TestRun run;
  run.truth = true;
  const std::string page = page_of(run);
  for (const char* text :
       {"ground truth</span>", "\"true_x\":", "0.13 m", "aligned by se3", "0.021 m", "NEES",
        "v1, live", "relative to the pose that fixes the map"}) {
    EXPECT_TRUE(has(page, text)) << text;
  }
  EXPECT_FALSE(has(page_of(TestRun{}), "\"true_x\":"));
}

TEST(Report, computes_ground_truth_in_the_map_by_subtracting_the_errors) {
  const io::TestFolder folder;
  TestRun test;
  test.truth = true;
  write_test_run(folder, test);
  const Result<RunData> run = read_run(folder.path());
  ASSERT_TRUE(run);
  ASSERT_EQ(run->vehicles[0].truth.size(), 200U);
  // Pose 10 is at x = 1.2; its error is (0.03, 0.01, -0.02) in axes equal to those of the map.
  EXPECT_NEAR(run->vehicles[0].truth[10].p_m.x(), 1.2 - 0.03, 1e-6);
  EXPECT_NEAR(run->vehicles[0].truth[10].p_m.z() - run->vehicles[0].path[10].p_m.z(), 0.02, 1e-6);
}

TEST(Report, rotates_errors_into_the_map_frame) {
  const io::TestFolder folder;
  TestRun test;
  test.truth = true;
  write_test_run(folder, test);
  // A quarter turn about z: x of the ground truth is -y of the map.
  std::string text = folder.read("evaluation.json");
  const std::string_view none = "\"quat_xyzw\":[0,0,0,1]";
  text.replace(text.find(none), none.size(),
               "\"quat_xyzw\":[0,0,0.70710678118654752,0.70710678118654752]");
  folder.write("evaluation.json", text);
  const Result<RunData> run = read_run(folder.path());
  ASSERT_TRUE(run);
  const VehicleView& v = run->vehicles[0];
  const geometry::Vec3 error_map = v.path[10].p_m - v.truth[10].p_m;
  EXPECT_NEAR(error_map.x(), 0.01, 1e-6);
  EXPECT_NEAR(error_map.y(), -0.03, 1e-6);
}

TEST(Report, of_ten_vehicles_names_all_and_stays_below_the_size_limit) {
  TestRun run;
  run.vehicles = test_names(10);
  run.fleet = run.truth = true;
  run.poses = 1200;
  run.points = 400'000;
  const std::string page = page_of(run);
  EXPECT_LT(page.size(), kPageBytesMax);
  for (const std::string& name : run.vehicles) EXPECT_TRUE(has(page, "<h3>" + name + "</h3>"));
  for (const char* text : {"all 10 vehicles in one frame", "no line of sight", "anchor",
                           "too few points", "0.12 m", "46 ms"}) {
    EXPECT_TRUE(has(page, text)) << text;
  }
}

TEST(Report, states_missing_parts_in_one_line_each) {
  TestRun run;
  run.points = 0;
  const std::string page = page_of(run);
  EXPECT_TRUE(has(page, "There is no map.pcd or map.ply with points."));
  EXPECT_TRUE(has(page, "No range was used"));
  EXPECT_TRUE(has(page, "No truth"));
  EXPECT_TRUE(has(page, "there is no map"));
}

TEST(Report, can_be_made_from_the_trajectory_alone) {
  const io::TestFolder folder;
  write_test_run(folder, TestRun{});
  for (const char* name :
       {"metrics.json", "status.json", "timing.json", "settings.yaml", "map.pcd"}) {
    std::filesystem::remove(folder.path(name));
  }
  const std::string page = page_of(folder);
  EXPECT_TRUE(has(page, "RaLI map of v1"));
  EXPECT_TRUE(has(page, "There is no timing.json."));
  EXPECT_FALSE(has(page, "state good"));
}

TEST(Report, of_a_folder_without_a_run_is_refused_with_a_remedy) {
  const io::TestFolder folder;
  const Result<RunData> run = read_run(folder.path());
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, ErrorCode::kInput);
  EXPECT_FALSE(run.error().remedy.empty());
  EXPECT_FALSE(read_run(folder.path("nothing")));
}

TEST(Report, escapes_markup_in_names_and_findings) {
  TestRun run;
  run.vehicles = {"</script><script>alert(1)</script>", "\"><img src=x onerror=alert(2)>",
                  "a' onload='x"};
  run.vehicles[0].erase(1, 1);  // a file name holds no slash
  run.warning = "</script><b>bold</b> & \"quoted\"";
  const io::TestFolder folder;
  write_test_run(folder, run);
  folder.write("trajectory/\xFF\xFE.tum", "1700000000 0 0 0 0 0 0 1\n");
  const std::string page = without_bulk(page_of(folder));
  EXPECT_FALSE(has(page, "<script>alert"));
  EXPECT_FALSE(has(page, "<img"));
  EXPECT_FALSE(has(page, "<b>bold"));
  EXPECT_FALSE(has(page, "' onload='"));
  EXPECT_FALSE(has(page, "\xFF"));
  EXPECT_TRUE(has(page, "&lt;/script&gt;&lt;b&gt;bold&lt;/b&gt; &amp; &quot;quoted&quot;"));
  EXPECT_EQ(count(page, "</script>"), 1U) << "only the data of the drawings";
}

TEST(Report, does_not_read_outside_of_its_folder) {
  TestRun run;
  run.vehicles = {"../../etc/passwd"};
  EXPECT_TRUE(has(page_of(run), "is no name of a vehicle"));
}

TEST(Report, prints_no_nan_or_infinity) {
  const io::TestFolder folder;
  write_test_run(folder, TestRun{});
  folder.write("trajectory/v1.cov.csv",
               "stamp_s,c00,c11,c22\n1700000000.0,nan,inf,1\n1700000001.0,-1,0,0\nx,1,1,1\n");
  folder.write(
      "degeneracy/v1.csv",
      "stamp_s,degenerate,degree,dir_x,dir_y,dir_z,sigma_degenerate_m,correction_m,range_from\n"
      "1700000000.0,1,inf,nan,nan,nan,inf,,\n1700000001.0,1,nan,,,,nan,,\n");
  folder.write(
      "metrics.json",
      R"({"vehicles":{"v1":{"path_m":null,"sigma_max_m":1e999,"degenerate_fraction":"x"}}})");
  const std::string page = without_bulk(page_of(folder));
  for (const char* text : {">nan", "nan m", ">inf", "inf m", "NaN", "Mnan", "Lnan", " inf"}) {
    EXPECT_FALSE(has(page, text)) << text;
  }
}

TEST(Report, is_written_from_files_truncated_anywhere) {
  const io::TestFolder folder;
  TestRun run;
  run.vehicles = {"v1", "v2"};
  run.fleet = run.truth = true;
  run.poses = 6;
  run.points = 50;
  write_test_run(folder, run);
  for (const char* name : {"metrics.json", "evaluation.json", "trajectory/v1.tum", "ranges.csv",
                           "degeneracy/v2.csv", "map.pcd", "settings.yaml", "status.json"}) {
    const std::string whole = folder.read(name);
    for (std::size_t length = 0; length < whole.size(); length += whole.size() / 12 + 1) {
      folder.write(name, whole.substr(0, length));
      EXPECT_GT(page_of(folder).size(), 1000U) << name << " cut at " << length;
    }
    folder.write(name, whole);
  }
}

TEST(Report, names_the_files_that_it_could_not_read) {
  const io::TestFolder folder;
  write_test_run(folder, TestRun{});
  folder.write("map.pcd", "no cloud");
  folder.write("timing.json", "[1, 2");
  const std::string page = page_of(folder);
  EXPECT_TRUE(has(page, "timing.json: no JSON object"));
  EXPECT_TRUE(has(page, "<li>map.pcd: "));
}

TEST(Report, of_the_same_data_is_identical_except_for_the_speed) {
  const io::TestFolder a, b;
  TestRun run;
  run.truth = true;
  write_test_run(a, run);
  write_test_run(b, run);
  b.write("timing.json", R"({"total_s":99.0,"data_s":20.0,"speed":0.2,"stages_s":{"open":1}})");
  std::string pages[2] = {page_of(a), page_of(b)};
  EXPECT_NE(pages[0], pages[1]);
  for (std::string& page : pages) {
    const std::size_t begin = page.find(kSpeedStart), end = page.find(kSpeedEnd);
    ASSERT_LT(begin, end);
    page.erase(begin, end - begin);
  }
  EXPECT_EQ(pages[0], pages[1]);
}

TEST(Report, loads_no_external_resources) {
  const std::string page = without_bulk(page_of(TestRun{}));
  EXPECT_TRUE(has(page, "default-src 'none'"));
  for (const char* text : {"src=\"http", "href=\"http", "@import", "url(http", "<link"}) {
    EXPECT_FALSE(has(page, text)) << text;
  }
}

TEST(Report, contains_the_licences_of_its_script_libraries) {
  const std::string page = page_of(TestRun{});
  if (has(page, "built without the drawings")) GTEST_SKIP() << "BUILT WITHOUT SCRIPTS (RALI_WEB)";
  EXPECT_TRUE(has(page, "three.js authors"));
  EXPECT_TRUE(has(page, "Leon Sorokin")) << "uPlot";
  EXPECT_TRUE(has(page, "THE SOFTWARE IS PROVIDED"));
}

TEST(Report, compares_runs_side_by_side) {
  const io::TestFolder a, b;
  write_test_run(a, TestRun{});
  TestRun other;
  other.truth = true;
  write_test_run(b, other);
  b.write("settings.yaml", "vehicles:\n  v1:\n    lidar:\n      model: vlp16   # fleet.yaml:5\n");
  const std::string path = a.path("comparison.html");
  ASSERT_TRUE(write_comparison({a.path(), b.path()}, path));
  const std::string page = a.read("comparison.html");
  for (const char* text : {"RaLI: 2 runs side by side", "vlp16", "rs16", "v1: path", "0.13 m"}) {
    EXPECT_TRUE(has(page, text)) << text;
  }
  EXPECT_FALSE(write_comparison({a.path(), a.path("none")}, path));
}

TEST(Settings, that_differ_from_the_default_keep_path_and_origin) {
  const auto lines = settings_other_than_default(
      "schema: 1                 # f.yaml:1\nvehicles:\n  v1:\n    start_s: 0   # default\n"
      "    lidar:\n      topic: /a#b     # found: the recording\n  v2:\n    start_s: 3 # -\nx: "
      "y\n");
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0].key, "schema");
  EXPECT_EQ(lines[1].key, "vehicles.v1.lidar.topic");
  EXPECT_EQ(lines[1].value, "/a#b");
  EXPECT_EQ(lines[1].origin, "found: the recording");
  EXPECT_EQ(lines[2].key, "vehicles.v2.start_s");
}

TEST(DegenerateSpans, join_across_single_observable_scans_and_name_the_constraining_peer) {
  const io::TestFolder folder;
  TestRun test;
  test.vehicles = {"v1", "v2"};
  write_test_run(folder, test);
  const Result<RunData> run = read_run(folder.path());
  ASSERT_TRUE(run);
  EXPECT_TRUE(run->vehicles[0].degenerate.empty());
  ASSERT_EQ(run->vehicles[1].degenerate.size(), 1U);
  EXPECT_NEAR(run->vehicles[1].degenerate[0].start_s, 8.0, 1e-6);
  EXPECT_NEAR(run->vehicles[1].degenerate[0].end_s, 12.9, 1e-6);
  EXPECT_EQ(run->vehicles[1].degenerate[0].held_by, "v1");
}

}  // namespace
}  // namespace rali::report
