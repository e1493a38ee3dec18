#include <cmath>

#include <gtest/gtest.h>

#include "rali/report/internal/cell_thinner.hpp"
#include "rali/report/internal/test_run.hpp"
#include "rali/report/read_run.hpp"
#include "rali/report/report.hpp"

namespace rali::report {
namespace {

constexpr std::string_view kColumns =
    "stamp_s,from,to,range_m,predicted_m,residual_m,sigma_m,bias_m,p_los,used,reason\n";

RunData read(const io::TestFolder& folder, const std::string& rows) {
  std::filesystem::create_directories(folder.path("trajectory"));
  for (const char* name : {"v1", "v2", "v3"}) {
    folder.write(fmt::format("trajectory/{}.tum", name),
                 "1000 0 0 0 0 0 0 1\n1100 9 0 0 0 0 0 1\n");
  }
  folder.write("ranges.csv", std::string(kColumns) + rows);
  Result<RunData> run = read_run(folder.path());
  EXPECT_TRUE(run);
  return run ? std::move(*run) : RunData();
}

std::size_t count(const PairRanges& pair, RangeOutcome outcome) {
  return pair.count[static_cast<std::size_t>(outcome)];
}

TEST(RangeTable, counts_outcomes_per_pair_in_both_directions) {
  const io::TestFolder folder;
  const RunData run = read(folder,
                           "1001,v1,v2,5,5,0.1,0.1,0.12,1,1,used\n1002,v2,v1,5,5,-0.1,0.1,0.13,1,1,"
                           "used\n1003,v1,v2,6,5,0.9,0.1,,0.1,0,nlos\n1004,v3,v1,9,,,,,,0,no_pose\n"
                           "1005,v1,17,9,,,,,,0,unknown_id\n");
  ASSERT_EQ(run.range_table.pairs.size(), 2U);
  const PairRanges& pair = run.range_table.pairs[0];
  EXPECT_EQ(pair.a, "v1");
  EXPECT_EQ(pair.b, "v2");
  EXPECT_EQ(pair.used(), 2U);
  EXPECT_EQ(count(pair, RangeOutcome::kNlos), 1U);
  EXPECT_EQ(pair.bias_m, 0.13);
  // 0.1 and -0.1: mean 0, variance (0.01 + 0.01) / 1.
  EXPECT_NEAR(pair.residual_std_m, std::sqrt(0.02), 1e-12);
  EXPECT_EQ(count(run.range_table.pairs[1], RangeOutcome::kNoPose), 1U);
  EXPECT_EQ(run.range_table.strangers, 1U);
  EXPECT_EQ(run.range_table.stranger_names, std::vector<std::string>{"17"});
}

TEST(RangeTable, shows_its_numbers_in_the_page) {
  const io::TestFolder folder;
  std::string rows;
  for (int i = 0; i < 90; ++i) {
    rows += fmt::format("{},v1,v2,5,5,{},0.1,0.12,1,{},{}\n", 1000 + i, i % 3 == 0 ? 0.8 : 0.01,
                        i % 3 == 0 ? 0 : 1, i % 3 == 0 ? "blocked_by_gate" : "used");
  }
  const std::string page = report_html(read(folder, rows));
  EXPECT_NE(page.find("<td>v1-v2</td><td>90</td><td>60</td><td>30</td><td>0.120 m, &plusmn; not "
                      "known</td></tr>"),
            std::string::npos);
  EXPECT_NE(page.find("\"label\":\"stopped by the gate\""), std::string::npos);
}

TEST(RangeTable, does_not_count_inconsistent_or_unknown_reasons_as_used) {
  EXPECT_EQ(outcome_of("used", true), RangeOutcome::kUsed);
  EXPECT_EQ(outcome_of("used", false), RangeOutcome::kOther);
  EXPECT_EQ(outcome_of("nlos", true), RangeOutcome::kOther);
  EXPECT_EQ(outcome_of("nlos", false), RangeOutcome::kNlos);
  EXPECT_EQ(outcome_of("<script>", false), RangeOutcome::kOther);
  EXPECT_EQ(outcome_of("", true), RangeOutcome::kUsed);
  EXPECT_EQ(outcome_of("", false), RangeOutcome::kOther);
}

TEST(RangeTable, of_invalid_rows_gives_a_page_without_their_tags) {
  const io::TestFolder folder;
  std::string rows =
      "nan,v1,v2,nan,inf,-inf,,,,1,used\n1e300,v1,v2,1,1,1e308,,,,0,outlier\n,,,,,,,,,,\n"
      "1001,<img src=x>,v1,,,,,,,0,<script>alert(1)</script>\n1002,v1\n";
  for (int i = 0; i < 300; ++i) rows += fmt::format("1003,x{},y{},1,1,0.1,,,,0,r{}\n", i, i, i);
  const RunData run = read(folder, rows);
  EXPECT_LE(run.range_table.stranger_names.size(), 5U);
  EXPECT_LE(run.range_table.other_reasons.size(), 5U);
  const std::string page = report_html(run);
  for (const char* text : {"<script>alert", "<img src", ">nan", "nan m", "Mnan", "inf m"}) {
    EXPECT_EQ(page.find(text), std::string::npos) << text;
  }
}

TEST(CellThinner, keeps_a_point_of_a_short_outlier_cluster) {
  CellThinner thinner(400);
  std::vector<RangeDot> all;
  for (int i = 0; i < 20'000; ++i) {
    all.push_back({0.05 * i, 0.06 * std::sin(1.7 * i)});
    if (i >= 9'000 && i < 9'040) all.push_back({0.05 * i, 2.5});  // a cluster of 2 s
  }
  for (const RangeDot& dot : all) thinner.add(dot);
  const std::vector<RangeDot> kept = thinner.dots();
  EXPECT_LE(kept.size(), 400U);
  EXPECT_GT(kept.size(), 100U);
  bool cluster = false;
  for (const RangeDot& dot : kept)
    cluster |= dot.residual_m == 2.5 && dot.t_s >= 450.0 && dot.t_s < 452.0;
  EXPECT_TRUE(cluster);
}

TEST(CellThinner, terminates_for_extreme_and_nan_values) {
  CellThinner thinner(3);
  for (const double t : {0.0, -1e300, 1e300, std::nan(""), 1e9, 5.0, 7.0}) {
    for (const double r : {0.0, 1e308, -1e308, std::nan(""), 1e-300}) thinner.add({t, r});
  }
  EXPECT_GT(thinner.dots().size(), 0U);
  EXPECT_LT(thinner.dots().size(), 100U);
}

TEST(ReceivedBins, are_at_most_2000_and_count_every_range) {
  ReceivedBins bins;
  for (int i = 0; i < 30'000; ++i) bins.add(1.1 * i, i % 4 != 0);
  std::size_t used = 0, rejected = 0;
  for (const Received& h : bins.spans()) used += h.used, rejected += h.rejected;
  EXPECT_EQ(used, 22'500U);
  EXPECT_EQ(rejected, 7'500U);
  EXPECT_LE(bins.spans().size(), 2000U);
}

}  // namespace
}  // namespace rali::report
