#include <fstream>

#include <gtest/gtest.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/internal/test_run.hpp"
#include "rali/report/read_run.hpp"
#include "rali/report/report.hpp"
#include "rali/report/section/degenerate_words.hpp"

namespace rali::report {
namespace {

constexpr std::string_view kColumns =
    "stamp_s,degenerate,degree,dir_x,dir_y,dir_z,sigma_degenerate_m,correction_m,range_from,axis,"
    "category,"
    "sigma_m,constrained_by\n";

/// A vehicle that drives along x, 1 m per second and row. A row: degenerate, sigma_m, range_from,
/// held_by.
struct Row {
  int degenerate = 0;
  double sigma_m = 0.02;
  std::string range_from, held_by = "lidar";
  double axis_x = 1.0, axis_y = 0.0;
};

VehicleView read(const std::vector<Row>& rows, const std::string& ranges = "", double step_m = 1.0,
                 const std::string& name = "v2") {
  const io::TestFolder folder;
  std::filesystem::create_directories(folder.path("trajectory"));
  std::filesystem::create_directories(folder.path("degeneracy"));
  std::string tum, csv(kColumns);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& r = rows[i];
    tum += fmt::format("{}.000000000 {} 0 0 0 0 0 1\n", 1000 + i, step_m * static_cast<double>(i));
    csv += fmt::format("{}.000000000,{},9,{},{},0,,,{},axial,{},{},{}\n", 1000 + i, r.degenerate,
                       r.axis_x, r.axis_y, r.range_from, r.degenerate != 0 ? "none" : "full",
                       r.sigma_m, r.held_by);
  }
  folder.write("trajectory/" + name + ".tum", tum);
  folder.write("trajectory/v1.tum", "1000 5 0 0 0 0 0 1\n");
  folder.write("degeneracy/" + name + ".csv", csv);
  if (!ranges.empty())
    folder.write("ranges.csv", "stamp_s,from,to,residual_m,used,reason\n" + ranges);
  const Result<RunData> run = read_run(folder.path());
  EXPECT_TRUE(run);
  for (const VehicleView& v : run->vehicles) {
    if (v.name == name) return v;
  }
  return {};
}

std::vector<Row> tunnel(const std::string& held_by, std::size_t n, double sigma_m) {
  std::vector<Row> rows(11);
  const Row degenerate{1, sigma_m, held_by == "range" ? "v1" : "", held_by};
  rows.insert(rows.end(), n, degenerate);
  return rows;
}

TEST(DegeneratePath, assigns_each_step_to_the_scan_at_its_end) {
  // 11 observable scans (10 m), then 20 m constrained by ranges, 5 m by inertia, 4 m by nothing.
  std::vector<Row> rows = tunnel("range", 20, 0.1);
  rows.insert(rows.end(), 5, Row{1, 0.3, "", "imu"});
  rows.insert(rows.end(), 4, Row{1, 2.5, "", "nothing"});
  const VehicleView v = read(rows);
  EXPECT_DOUBLE_EQ(v.degenerate_path.all.m, 39.0);
  EXPECT_DOUBLE_EQ(v.degenerate_path.degenerate.m, 29.0);
  EXPECT_DOUBLE_EQ(v.degenerate_path.held[1].m, 20.0);
  EXPECT_DOUBLE_EQ(v.degenerate_path.held[2].m, 5.0);
  EXPECT_DOUBLE_EQ(v.degenerate_path.held[3].m, 4.0);
  EXPECT_DOUBLE_EQ(v.degenerate_path.degenerate.s, 29.0);
  EXPECT_DOUBLE_EQ(v.degenerate_path.peak.off_m, 2.5);
  EXPECT_EQ(v.degenerate_path.range_names, std::vector<std::string>{"v1"});
  EXPECT_NEAR(unheld_fraction(v), 4.0 / 39.0, 1e-12);
}

TEST(DegeneratePath, does_not_bridge_gaps_of_removed_scans) {
  const io::TestFolder folder;
  std::filesystem::create_directories(folder.path("trajectory"));
  std::filesystem::create_directories(folder.path("degeneracy"));
  folder.write("trajectory/v1.tum",
               "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n9 50 0 0 0 0 0 1\n"
               "10 51 0 0 0 0 0 1\n");
  folder.write("degeneracy/v1.csv", std::string(kColumns) +
                                        "1,1,,1,0,0,,,,,,1,nothing\n"
                                        "2,1,,1,0,0,,,,,,1,nothing\n9,1,,1,0,0,,,,,,1,nothing\n"
                                        "10,1,,1,0,0,,,,,,1,nothing\n");
  const Result<RunData> run = read_run(folder.path());
  ASSERT_TRUE(run);
  EXPECT_DOUBLE_EQ(run->vehicles[0].degenerate_path.all.m, 2.0);
}

TEST(DegeneratePath, without_a_range_received_within_2_s_is_measured) {
  // Degenerate from 11 to 30 s. One range at 15.2 s: its bin is 15.0 to 15.5 s, so 13 to 17 s count
  // as received.
  const VehicleView v = read(tunnel("nothing", 20, 1.0), "1015.2,v1,v2,0.5,0,nlos\n");
  ASSERT_EQ(v.received.size(), 1U);
  EXPECT_EQ(v.received[0].rejected, 1U);
  EXPECT_DOUBLE_EQ(v.degenerate_path.without_range.m, 20.0 - 5.0);
}

TEST(DegenerateSentence, gives_distance_constraint_and_largest_expected_error) {
  std::vector<Row> rows = tunnel("range", 190, 0.1);
  rows[154].sigma_m = 0.31;
  EXPECT_EQ(
      degenerate_sentence_of(read(rows)),
      "v2 was degenerate along its path for 190 of 200 m, constrained by ranges to v1 for "
      "all of it; the expected error there is at most 0.31 m along its path, at 154 s (1 sigma)");
}

TEST(DegenerateSentence, gives_the_expected_error_of_the_unconstrained_part) {
  std::vector<Row> rows = tunnel("range", 150, 0.1);
  rows.insert(rows.end(), 40, Row{1, 12.0, "", "nothing"});
  EXPECT_EQ(
      degenerate_sentence_of(read(rows)),
      "v2 was degenerate along its path for 190 of 200 m, constrained by ranges to v1 for 79 % of "
      "it; nothing constrained it for 40.0 m: the expected error there is 12.0 m along its "
      "path (1 sigma)");
}

TEST(DegenerateSentence, never_rounds_up_to_all_and_reports_single_unconstrained_metres) {
  std::vector<Row> rows = tunnel("range", 400, 0.1);
  rows.push_back({1, 0.8, "", "nothing"});
  const std::string text = degenerate_sentence_of(read(rows));
  EXPECT_NE(text.find("for over 99 % of it; nothing constrained it for 1.0 m"), std::string::npos)
      << text;
  EXPECT_NE(text.find("error there is 0.80 m"), std::string::npos) << text;
}

TEST(DegenerateSentence, states_if_the_size_of_the_error_is_unknown) {
  std::vector<Row> rows = tunnel("nothing", 30, kUnknown);
  EXPECT_EQ(degenerate_sentence_of(read(rows)),
            "v2 was degenerate along its path for 30.0 of 40.0 m; nothing constrained it there: "
            "how large the error is there is not known");
}

TEST(DegenerateSentence, gives_the_degenerate_axis_relative_to_the_path) {
  std::vector<Row> across = tunnel("range", 30, 0.1);
  for (Row& row : across) row.axis_x = 0.0, row.axis_y = 1.0;
  EXPECT_NE(degenerate_sentence_of(read(across)).find("degenerate across its path for"),
            std::string::npos);
}

TEST(DegenerateSentence, measures_a_standing_vehicle_in_seconds) {
  const std::string text = degenerate_sentence_of(read(tunnel("imu", 30, 0.05), "", 0.001));
  EXPECT_EQ(text.substr(0, text.find(" for 30.0")),
            "v2 stood still and was degenerate along a level axis");
  EXPECT_NE(text.find("for 30.0 of 40.0 s, constrained by inertia and standstill for all of it"),
            std::string::npos)
      << text;
}

TEST(DegenerateSentence, escapes_vehicle_names) {
  const std::string text = degenerate_sentence_of(read(tunnel("range", 30, 0.1), "", 1.0, "<b>x"));
  EXPECT_EQ(text.find("<b>"), std::string::npos);
  EXPECT_NE(text.find("&lt;b&gt;x was degenerate"), std::string::npos);
}

TEST(DegeneracyFile, of_an_older_version_is_read_without_the_new_columns) {
  const io::TestFolder folder;
  TestRun test;
  test.vehicles = {"v1", "v2"};
  test.old_degeneracy = true;
  write_test_run(folder, test);
  ASSERT_EQ(folder.read("degeneracy/v2.csv").find("constrained_by"), std::string::npos);
  const Result<RunData> run = read_run(folder.path());
  ASSERT_TRUE(run);
  const VehicleView& v = run->vehicles[1];
  ASSERT_TRUE(was_degenerate(v));
  EXPECT_EQ(v.degeneracy[0].held_by, HeldBy::kLidar);
  EXPECT_EQ(v.degeneracy[90].held_by, HeldBy::kRange);
  EXPECT_EQ(v.degeneracy[90].sight, Sight::kNone);
  EXPECT_EQ(held_fraction(v, HeldBy::kRange), 1.0);
}

TEST(DegeneracyFile, with_unknown_words_counts_as_unconstrained) {
  std::vector<Row> rows = tunnel("<i>magic", 20, 0.1);
  EXPECT_EQ(held_fraction(read(rows), HeldBy::kNothing), 1.0);
}

TEST(Report, shows_the_degeneracy_sentence_of_a_tunnel) {
  const io::TestFolder folder;
  TestRun test;
  test.vehicles = {"v1", "v2"};
  write_test_run(folder, test);
  std::string csv(kColumns);
  for (int i = 0; i < 200; ++i) {
    csv += fmt::format("{:.9f},{},9,1,0,0,,,,axial,{},{},{}\n", 1700000000.0 + 0.1 * i,
                       i >= 80 ? 1 : 0, i >= 80 ? "none" : "full", i >= 80 ? 3.0 : 0.02,
                       i >= 80 ? "nothing" : "lidar");
  }
  folder.write("degeneracy/v2.csv", csv);
  std::filesystem::remove(folder.path("trajectory/v2.cov.csv"));
  const Result<RunData> run = read_run(folder.path());
  ASSERT_TRUE(run);
  const std::string page = report_html(*run);
  for (const char* text :
       {"degenerate, constrained by nothing", "Largest uncertainty:</b> v2: nothing constrained it",
        "nothing constrained it there: the expected error there is 3.00 m", "\xE2\x9C\x97 bad"}) {
    EXPECT_NE(page.find(text), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace rali::report
