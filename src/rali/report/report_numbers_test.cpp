#include <gtest/gtest.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/internal/test_run.hpp"
#include "rali/report/read_run.hpp"
#include "rali/report/report.hpp"

namespace rali::report {
namespace {

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

std::size_t count(const std::string& page, std::string_view text) {
  std::size_t n = 0;
  for (std::size_t at = page.find(text); at != std::string::npos; at = page.find(text, at + 1)) ++n;
  return n;
}

/// The text of the page without tags, entities left as they are.
std::string text_of(const std::string& page) {
  std::string out;
  bool inside = false;
  for (const char c : page) {
    if (c == '<') inside = true;
    if (!inside) out += c;
    if (c == '>') inside = false;
  }
  return out;
}

TEST(ReportNumbers, show_the_numbers_of_evaluation_json_in_their_cells) {
  const io::TestFolder folder;
  TestRun run;
  run.truth = true;
  write_test_run(folder, run);
  const Result<RunData> read = read_run(folder.path());
  ASSERT_TRUE(read);
  const std::string page = page_of(folder);
  const std::string text = text_of(page);
  const auto value = [&](const char* key) {
    for (const Measured& m : read->evaluation) {
      if (m.key == key) return Number(m.value);
    }
    return Number();
  };
  // poses, APE rmse, largest, rotation, drift, in height, along, across: the row of v1.
  const std::string track = "vehicles.v1.trajectory.";
  const auto of = [&](const char* name) { return metres(value((track + name).c_str())); };
  const std::string row = "<td>v1</td><td>" + counted(value((track + "poses").c_str())) +
                          "</td><td>" + of("ape_m.rmse") + "</td><td>" + of("ape_m.max") +
                          "</td><td>0.20&deg;</td><td>" + of("drift_final_m") + "</td><td>" +
                          of("drift_z_m") + "</td><td>" + of("degenerate.along_m.rmse") +
                          "</td><td>" + of("degenerate.across_m.rmse") + "</td>";
  EXPECT_TRUE(has(page, row)) << row;
  EXPECT_EQ(of("ape_m.rmse"), "0.13 m");
  EXPECT_TRUE(has(text, "off by 0.13 m (rmse), at most 0.25 m"));
  EXPECT_TRUE(has(text, "mean 0.021 m, standard deviation 0.013 m, 95 % within 0.050 m"));
  EXPECT_TRUE(has(page, "<td>v1</td><td>1.0</td><td>5.50</td><td>94 %</td>"));
}

TEST(ReportNumbers, shows_each_vehicle_of_metrics_json_with_its_own_numbers) {
  const io::TestFolder folder;
  TestRun run;
  run.vehicles = test_names(3);
  write_test_run(folder, run);
  const Result<RunData> read = read_run(folder.path());
  ASSERT_TRUE(read);
  const std::string page = page_of(folder);
  for (const VehicleView& v : read->vehicles) {
    const std::string row = "<td>" + v.name + "</td><td>" + metres(v.numbers.path_m) + "</td><td>" +
                            counted(v.numbers.scans) + "</td><td>" + counted(v.numbers.keyframes) +
                            "</td><td>" + percent(v.numbers.degenerate_fraction) + "</td>";
    EXPECT_TRUE(has(page, row)) << row;
  }
}

TEST(ReportNumbers, do_not_rate_errors_beyond_the_stated_covariance_as_good) {
  const io::TestFolder folder;
  TestRun run;
  run.truth = true;
  write_test_run(folder, run);
  EXPECT_TRUE(has(page_of(folder), "no more than the stated covariance allows"));
  std::string text = folder.read("evaluation.json");
  // In the numbers of the fleet, at the end of the file.
  const std::string_view good = "\"fraction_within_95\":0.94";
  text.replace(text.rfind(good), good.size(), "\"fraction_within_95\":0.69");
  folder.write("evaluation.json", text);
  const std::string page = page_of(folder);
  EXPECT_FALSE(has(page, "no more than the stated covariance allows"));
  EXPECT_TRUE(has(page, "only 69 % of the poses lie within their 95 % bounds"));
}

TEST(ReportNumbers, show_degenerate_interval_axis_constraint_and_expected_error) {
  const io::TestFolder folder;
  TestRun run;
  run.vehicles = {"v1", "v2"};
  write_test_run(folder, run);
  const std::string page = page_of(folder);
  // Variance along x at pose 129: 1e-4 + 129 * 2e-5 = 0.00268, its root 0.0518 m. The trajectory
  // turns from x to y at pose 117, 14 m along.
  EXPECT_TRUE(has(page, "<td>v2</td><td>8.0 s</td><td>12.9 s</td>"));
  EXPECT_TRUE(has(page, "0&deg; from x of the map</td><td>ranges to v1, 100 %"));
  EXPECT_TRUE(has(page, "<b>&plusmn; 0.052 m</b>"));
}

TEST(ReportNumbers, do_not_draw_a_vehicle_into_another_frame) {
  const io::TestFolder folder;
  TestRun run;
  run.vehicles = {"v1", "v2"};
  write_test_run(folder, run);
  EXPECT_FALSE(has(page_of(folder), "not joined"));
  std::string metrics = folder.read("metrics.json");
  const std::string_view joined = R"([["v1","v2"]])";
  metrics.replace(metrics.find(joined), joined.size(), R"([["v1"],["v2"]])");
  folder.write("metrics.json", metrics);
  const Result<RunData> read = read_run(folder.path());
  ASSERT_TRUE(read);
  EXPECT_NE(read->vehicles[0].in_map, read->vehicles[1].in_map);
  const std::string page = page_of(folder);
  EXPECT_TRUE(has(page, "is not joined to it"));
  EXPECT_TRUE(has(page, "in a frame of its own</figcaption>"));
}

TEST(ReportNumbers, show_the_remaining_frontiers) {
  TestRun run;
  run.vehicles = {"v1", "v2"};
  run.fleet = true;
  const std::string page = page_of(run);
  EXPECT_TRUE(has(page, "Left in the end:"));
  EXPECT_TRUE(has(page, "behind the gate"));
  EXPECT_TRUE(has(page, "\"frontier 5: unreachable, 2.5 m\""));
  EXPECT_FALSE(has(page, "\"frontier 4"));
}

TEST(ReportNumbers, count_loops_per_pair_and_list_only_rejected_ones) {
  TestRun run;
  run.vehicles = {"v1", "v2"};
  run.fleet = true;
  const std::string page = page_of(run);
  EXPECT_TRUE(has(page, "v1 and v2"));
  EXPECT_EQ(count(page, "v1 at 2.0 s"), 1U) << "of a closed and a refused one from this time";
  EXPECT_TRUE(has(page, "too few points"));
}

TEST(ReportNumbers, show_which_measurements_fix_a_vehicle_in_the_first_frame) {
  const io::TestFolder folder;
  TestRun run;
  run.vehicles = {"v1", "v2"};
  run.fleet = true;
  write_test_run(folder, run);
  std::string metrics = folder.read("metrics.json");
  const std::string before = R"("loops_accepted")";
  metrics.replace(metrics.find(before), before.size(),
                  R"("frames":{"v1":{"decided_by":""},"v2":{"decided_by":"ranges and scans",)"
                  R"("sigma_m":0.02,"sigma_rad":0.0349066,"waits_for":""}},"loops_accepted")");
  folder.write("metrics.json", metrics);
  const std::string page = page_of(folder);
  EXPECT_TRUE(has(page, "ranges and scans"));
  EXPECT_TRUE(has(page, "2.00\xC2\xB0")) << "heading in degrees";
  const std::string known = R"("sigma_rad":0.0349066)";
  metrics.replace(metrics.find(known), known.size(), R"("sigma_rad":22.4)");
  folder.write("metrics.json", metrics);
  EXPECT_FALSE(has(page_of(folder), "1283.43\xC2\xB0")) << "more turns than a circle has";
}

TEST(ReportNumbers, offer_colour_by_vehicle_only_for_a_fleet) {
  TestRun run;
  EXPECT_FALSE(has(page_of(run), "<option value=\"vehicle\">"));
  run.vehicles = {"v1", "v2"};
  run.fleet = true;
  EXPECT_TRUE(has(page_of(run), "<option value=\"vehicle\">"));
}

TEST(ReportNumbers, show_the_date_and_time_of_the_data) {
  EXPECT_TRUE(has(page_of(TestRun{}), "data from 2023-11-14 22:13 UTC"));
}

TEST(ReportNumbers, show_measured_and_stated_imu_noise) {
  const io::TestFolder folder;
  write_test_run(folder, TestRun{});
  std::string metrics = folder.read("metrics.json");
  const std::string scale = R"("accel_scale":1.0)";
  metrics.replace(metrics.find(scale), scale.size(),
                  scale + R"(,"imu_noise":{"accel_mps2_rthz":0.108,"accel_stated_mps2_rthz":0.03,)"
                          R"("gyro_radps_rthz":null,"gyro_stated_radps_rthz":0.003})");
  folder.write("metrics.json", metrics);
  const std::string page = page_of(folder);
  EXPECT_TRUE(has(page, "<td>0.1080 / 0.0300</td>"));
  EXPECT_FALSE(has(page, "/ 0.00300")) << "not measured";
}

TEST(ReportNumbers, show_range_latency_as_estimated_configured_or_unknown) {
  const std::string given = R"("latency_s":0.046)";
  for (const auto& [json, cell] : {std::pair<std::string, std::string>{given, "46 ms, as set"},
                                   {given + R"(,"latency_sigma_s":0.005)", "46 &plusmn; 5 ms"},
                                   {R"("latency_s":null,"latency_sigma_s":null)", ""}}) {
    const io::TestFolder folder;
    TestRun run;
    run.vehicles = {"v1", "v2"};
    run.fleet = true;
    write_test_run(folder, run);
    std::string metrics = folder.read("metrics.json");
    metrics.replace(metrics.find(given), given.size(), json);
    folder.write("metrics.json", metrics);
    const std::string shown = cell.empty() ? "Not known: latency" : "<td>" + cell + "</td>";
    EXPECT_TRUE(has(page_of(folder), shown)) << shown;
  }
}

TEST(ReportNumbers, replace_a_huge_nees_by_a_sentence) {
  const io::TestFolder folder;
  TestRun run;
  run.truth = true;
  write_test_run(folder, run);
  std::string text = folder.read("evaluation.json");
  const std::string_view good = "\"mean\":5.5";
  for (std::size_t at = text.find(good); at != std::string::npos; at = text.find(good)) {
    text.replace(at, good.size(), "\"mean\":61234567890.5");
  }
  folder.write("evaluation.json", text);
  const std::string page = page_of(folder);
  EXPECT_TRUE(has(page, "errors of the pose are over 100 times the stated sigma"));
  EXPECT_TRUE(has(page, "<td>over 1000</td>"));
  EXPECT_FALSE(has(page, "6123"));
}

TEST(ReportNumbers, rate_a_map_as_good_only_if_keyframes_were_checked) {
  const auto found = [](const std::string& checks) {
    const io::TestFolder folder;
    write_test_run(folder, TestRun{});
    std::string metrics = folder.read("metrics.json");
    metrics.insert(1, checks);
    folder.write("metrics.json", metrics);
    const std::string page = page_of(folder);
    const std::size_t row = page.find("<td>map against its scans</td>");
    const std::size_t state = page.rfind("class=\"state ", row) + 13;
    return page.substr(state, page.find('"', state) - state);
  };
  const auto checks = [](int checked, int contradictions) {
    return fmt::format(
        R"("checks":{{"keyframes":370,"keyframes_checked":{},"contradictions":{}}},)", checked,
        contradictions);
  };
  EXPECT_EQ(found(""), "none");
  EXPECT_EQ(found(checks(0, 0)), "none");
  EXPECT_EQ(found(checks(30, 0)), "look");
  EXPECT_EQ(found(checks(370, 0)), "good");
  EXPECT_EQ(found(checks(370, 1)), "bad");
}

TEST(ReportNumbers, replace_plots_of_a_standing_vehicle_by_a_sentence) {
  const io::TestFolder folder;
  write_test_run(folder, TestRun{});
  EXPECT_TRUE(has(page_of(folder), "data-vehicle=\"0\""));
  std::string tum;
  for (int i = 0; i < 200; ++i) tum += fmt::format("{:.1f} 1 2 0 0 0 0 1\n", 1.7e9 + 0.1 * i);
  folder.write("trajectory/v1.tum", tum);
  const std::string page = page_of(folder);
  EXPECT_FALSE(has(page, "data-vehicle=\"0\""));
  EXPECT_TRUE(has(page, "It stood still for all 20 s"));
}

}  // namespace
}  // namespace rali::report
