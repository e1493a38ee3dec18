#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/cli/run_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

// `rali map` of two vehicles with ranges, from the command line to the files.

namespace rali::cli {
namespace {

/// The last cell of each row.
std::map<std::string, std::size_t> reasons_of(const std::string& csv) {
  std::map<std::string, std::size_t> reasons;
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);  // header
  while (std::getline(lines, line)) ++reasons[line.substr(line.rfind(',') + 1)];
  return reasons;
}

std::size_t rows_of(const std::string& csv) {
  return static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')) - 1;
}

class MapRanges : public testing::Test {
 protected:
  /// Two vehicles for two seconds, recorded once for all tests.
  static void SetUpTestSuite() {
    sim_ = new io::TestFolder();
    const Outcome done = run_rali({"simulate", "hall", "-o", sim_->path("sim"), "--vehicles", "2",
                                   "--duration", "2", "--progress", "off"});
    ASSERT_EQ(done.code, 0) << done.err;
  }

  static void TearDownTestSuite() { delete sim_; }

  [[nodiscard]] static std::string ranges_text() { return sim_->read("sim/ranges.csv"); }

  Outcome map(const std::string& out, const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"map",
                                      sim_->path("sim/fleet.yaml"),
                                      "-o",
                                      folder_.path(out),
                                      "--no-mcap",
                                      "--no-keyframes",
                                      "--no-report",
                                      "--progress",
                                      "off",
                                      "--formats",
                                      "ply",
                                      "--map-voxel",
                                      "0.5",
                                      "--set",
                                      "vehicles.v1.lidar.time_offset_s=0",
                                      "--set",
                                      "vehicles.v2.lidar.time_offset_s=0"};
    words.insert(words.end(), more.begin(), more.end());
    return run_rali(words);
  }

  io::TestFolder folder_;
  static io::TestFolder* sim_;
};

io::TestFolder* MapRanges::sim_ = nullptr;

TEST_F(MapRanges, each_have_one_row_with_a_reason_for_any_thread_count) {
  // Late, unknown, impossible and repeated rows in no order, behind those of the simulator.
  const std::string given = ranges_text();
  const std::size_t first = given.find('\n') + 1;
  const std::string row = given.substr(first, given.find('\n', first) + 1 - first);
  const std::string header = given.substr(0, first);
  ASSERT_EQ(header.substr(0, 26), "stamp_s,from,to,range_m,rs") << header;
  const std::string commas(
      static_cast<std::size_t>(std::count(header.begin(), header.end(), ',')) - 3, ',');
  const std::string all = given + "1700000001.0,v1,v7,3" + commas + "\n1700000000.5,v1,v2,900" +
                          commas + "\n1600000000,v1,v2,4" + commas + '\n' + row;
  const std::string file = folder_.write("ranges.csv", all);
  for (const char* threads : {"1", "2"}) {
    const Outcome done = map(threads, {"--ranges", file, "--threads", threads});
    ASSERT_EQ(done.code, 0) << done.err;
    EXPECT_NE(done.out.find("ranges: "), std::string::npos) << done.out;
    EXPECT_EQ(done.err.find("not used"), std::string::npos) << done.err;
  }
  const std::string table = folder_.read("1/ranges.csv");
  EXPECT_EQ(rows_of(table), rows_of(all));
  auto reasons = reasons_of(table);
  EXPECT_EQ(reasons["unknown_id"], 1U);
  EXPECT_EQ(reasons["out_of_limits"], 1U);
  EXPECT_GE(reasons["duplicate"], 1U);
  EXPECT_GE(reasons["no_pose"], 1U) << "the one from before the recordings";
  EXPECT_NE(table.find("1700000001.000000000,v1,v7,3.0000"), std::string::npos);
  for (const char* name : {"ranges.csv", "metrics.json", "trajectory/v1.tum", "trajectory/v2.tum",
                           "degeneracy/v1.csv", "odometry/v2.cov.csv", "map.ply"}) {
    EXPECT_EQ(folder_.read(std::string("1/") + name) == folder_.read(std::string("2/") + name),
              true)
        << name;
  }
  const auto metrics = nlohmann::json::parse(folder_.read("1/metrics.json"));
  EXPECT_EQ(metrics["ranges"]["total"], rows_of(all));
  EXPECT_EQ(metrics["ranges"]["rejected"]["unknown_id"], 1);
  EXPECT_TRUE(metrics["ranges"]["pairs"].contains("v1-v2"));
}

TEST_F(MapRanges, that_are_not_used_do_not_change_the_poses) {
  ASSERT_EQ(map("with", {"--set", "ranging.use=false"}).code, 0);
  ASSERT_EQ(map("without", {"--set", "ranges.sources=[]"}).code, 0);
  EXPECT_EQ(rows_of(folder_.read("with/ranges.csv")), rows_of(ranges_text()));
  EXPECT_FALSE(std::filesystem::exists(folder_.path("without/ranges.csv")));
  for (const char* name : {"trajectory/v1.tum", "odometry/v2.tum"}) {
    EXPECT_EQ(
        folder_.read(std::string("with/") + name) == folder_.read(std::string("without/") + name),
        true)
        << name;
  }
}

TEST_F(MapRanges, that_are_missing_or_name_unknown_vehicles_are_an_input_error) {
  const std::string strangers =
      folder_.write("strangers.csv", "stamp_s,from,to,range_m\n1,a,b,3\n");
  for (const std::string& file : {folder_.path("none.csv"), strangers, sim_->path("sim/v1.mcap")}) {
    const Outcome refused = map("out", {"--ranges", file});
    EXPECT_EQ(refused.code, 2) << refused.err;
    EXPECT_NE(refused.err.find(file), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(folder_.path("out/status.json")));
  }
}

/// A ranges.csv with all stamps later by this time, so that the ranges have a latency.
std::string stamped_late(const std::string& csv, double late_s) {
  std::istringstream lines(csv);
  std::string line, out;
  std::getline(lines, line);
  out = line + '\n';
  while (std::getline(lines, line)) {
    const std::size_t comma = line.find(',');
    const auto ns = static_cast<long long>(std::llround(1e9 * late_s));
    const std::size_t dot = line.find('.');
    const long long s = std::stoll(line.substr(0, dot));
    std::string part = dot < comma ? line.substr(dot + 1, comma - dot - 1) : "0";
    part.resize(9, '0');
    const long long at = std::stoll(part) + ns;
    out += fmt::format("{}.{:09d}{}\n", s + at / 1'000'000'000, at % 1'000'000'000,
                       line.substr(comma));
  }
  return out;
}

TEST(MapRangeLatency, estimated_by_the_filters_is_in_metrics_settings_and_report) {
  const io::TestFolder f;
  const Outcome done = run_rali({"simulate", "hall", "-o", f.path("sim"), "--vehicles", "2",
                                 "--duration", "24", "--progress", "off"});
  ASSERT_EQ(done.code, 0) << done.err;
  f.write("sim/ranges.csv", stamped_late(f.read("sim/ranges.csv"), 0.08));
  const Outcome map =
      run_rali({"map", f.path("sim/fleet.yaml"), "-o", f.path("out"), "--no-mcap", "--no-keyframes",
                "--progress", "off", "--map-voxel", "0.5", "--set",
                "vehicles.v1.lidar.time_offset_s=0", "--set", "vehicles.v2.lidar.time_offset_s=0"});
  ASSERT_EQ(map.code, 0) << map.err;
  const auto metrics = nlohmann::json::parse(f.read("out/metrics.json"));
  const auto& pair = metrics["ranges"]["pairs"]["v1-v2"];
  ASSERT_TRUE(pair["latency_s"].is_number()) << pair.dump();
  const double sigma_s = pair["latency_sigma_s"];
  EXPECT_NEAR(pair["latency_s"].get<double>(), 0.08, 4.0 * sigma_s + 0.01) << sigma_s;
  EXPECT_NE(f.read("out/settings.yaml").find("ms, by motion"), std::string::npos);
  const std::string cell = fmt::format("{:.0f} &plusmn; {:.0f} ms</td>",
                                       1e3 * pair["latency_s"].get<double>(), 1e3 * sigma_s);
  EXPECT_NE(f.read("out/report.html").find(cell), std::string::npos) << cell;
}

}  // namespace
}  // namespace rali::cli
