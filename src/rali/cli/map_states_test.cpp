#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/cli/run_for_test.hpp"
#include "rali/drive/fleet_loop.hpp"
#include "rali/drive/member_job.hpp"
#include "rali/drive/open_events.hpp"
#include "rali/drive/ranges/range_files.hpp"
#include "rali/drive/state/states_for_test.hpp"
#include "rali/drive/tbb_executor.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/jobs/load_inputs.hpp"
#include "rali/jobs/map_job.hpp"
#include "rali/vehicle/vehicle.hpp"

// `rali map` of state folders, from the command line to the files, compared with that of the
// recording of the same vehicles.

namespace rali::cli {
namespace {

namespace fs = std::filesystem;

using Facts = std::vector<fleet::FactPtr>;

class Silent final : public drive::ProgressSink {
 public:
  void progress(const drive::Progress& /*progress*/) override {}

  void finding(const Finding& /*finding*/) override {}
};

/// The facts that the vehicles of a recording exchange, vehicle by vehicle.
std::vector<Facts> reported_by(const std::string& fleet_yaml, const std::string& scratch) {
  const auto inputs = jobs::load_inputs({fleet_yaml}, {});
  EXPECT_TRUE(inputs);
  const auto job = jobs::make_map_job(inputs->fleet, {});
  EXPECT_TRUE(job);
  const auto ranges = std::make_shared<const drive::RangeOptions>(job->ranges);
  const std::size_t n = job->vehicles.size();
  std::vector<std::unique_ptr<drive::ReportedSource>> sources;
  std::vector<vehicle::Vehicle> vehicles;
  std::vector<drive::VehicleRun> runs;
  std::vector<Facts> reported(n);
  runs.reserve(n);
  vehicles.reserve(n);
  std::vector<drive::FleetMember> members(n);
  for (std::size_t i = 0; i < n; ++i) {
    const VehicleId id{static_cast<std::uint16_t>(i)};
    sources.push_back(std::move(*drive::open_events(drive::member_job(*job, i, ranges))));
    vehicles.emplace_back(id,
                          drive::settings_with(job->vehicles[i].settings, sources[i]->report()));
    runs.push_back(std::move(*drive::VehicleRun::start(fmt::format("v{}", i), scratch, nullptr)));
    members[i].source = sources[i].get();
    members[i].run = &runs[i];
    members[i].step = [&vehicle = vehicles[i], &facts = reported[i]](const vehicle::Event& event,
                                                                     Executor& executor,
                                                                     vehicle::OutputList& out) {
      const std::size_t before = out.size();
      vehicle.step(event, executor, out);
      for (std::size_t k = before; k < out.size(); ++k) {
        const auto* made = std::get_if<vehicle::FactMade>(&out[k]);
        if (made == nullptr) continue;
        const fleet::Fact& f = *made->fact;
        facts.push_back(drive::quantised_fact(f.key.vehicle, 0, f.key.seq, f.t.s(), f.body));
      }
    };
  }
  drive::RangeLog log(drive::vehicle_names(*job));
  Silent sink;
  const std::atomic<bool> stop{false};
  const auto executor = drive::make_executor(1);
  drive::run_fleet(members, drive::read_range_files(job->ranges)->samples, job->ranges, {},
                   *executor, log, nullptr, sink, stop);
  return reported;
}

/// Keyframe by keyframe of keyframes.csv: vehicle and number to x, y, z.
std::map<std::string, std::array<double, 3>> keyframes_in(const std::string& csv) {
  std::map<std::string, std::array<double, 3>> out;
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::vector<std::string> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
    out[row.at(1) + row.at(2)] = {std::stod(row.at(4)), std::stod(row.at(5)), std::stod(row.at(6))};
  }
  return out;
}

class MapStates : public testing::Test {
 protected:
  /// Two vehicles for 14 seconds; each has its own facts, and one folder has all.
  static void SetUpTestSuite() {
    sim_ = new io::TestFolder();
    const Outcome done = run_rali({"simulate", "hall", "-o", sim_->path("sim"), "--vehicles", "2",
                                   "--duration", "14", "--progress", "off"});
    ASSERT_EQ(done.code, 0) << done.err;
    const auto reported = reported_by(sim_->path("sim/fleet.yaml"), sim_->path("scratch"));
    ASSERT_EQ(reported.size(), 2U);
    drive::write_state(sim_->path("v1"), {0}, reported[0]);
    drive::write_state(sim_->path("v2"), {1}, reported[1]);
    Facts all = reported[1];
    all.insert(all.end(), reported[0].begin(), reported[0].end());
    drive::write_state(sim_->path("all"), {0}, all);
  }

  static void TearDownTestSuite() { delete sim_; }

  static std::string at(const std::string& name) { return sim_->path(name); }

  Outcome map(const std::string& out, const std::vector<std::string>& inputs,
              const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"map", "-o", folder_.path(out), "--progress", "off"};
    words.insert(words.end(), {"--formats", "ply", "--map-voxel", "0.2"});
    words.insert(words.end(), inputs.begin(), inputs.end());
    words.insert(words.end(), more.begin(), more.end());
    return run_rali(words);
  }

  io::TestFolder folder_;
  static io::TestFolder* sim_;
};

io::TestFolder* MapStates::sim_ = nullptr;

TEST_F(MapStates, the_map_from_facts_agrees_with_the_map_from_recordings) {
  const Outcome recorded = map("recorded", {at("sim/fleet.yaml")}, {"--no-report"});
  ASSERT_EQ(recorded.code, 0) << recorded.err;
  const Outcome reported =
      map("told", {at("sim/fleet.yaml"), at("v2"), at("v1")}, {"--truth", at("sim/truth")});
  ASSERT_EQ(reported.code, 0) << reported.err;
  EXPECT_NE(reported.err.find("its recordings and files of ranges are left out"),
            std::string::npos);
  EXPECT_NE(reported.err.find("no odometry/, no live/"), std::string::npos);
  EXPECT_NE(reported.out.find("against the truth"), std::string::npos) << reported.out;

  const auto there = keyframes_in(folder_.read("recorded/keyframes.csv"));
  const auto here = keyframes_in(folder_.read("told/keyframes.csv"));
  EXPECT_GE(here.size(), 4U);
  ASSERT_EQ(here.size(), there.size());
  for (const auto& [name, p_m] : here) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(p_m[axis], there.at(name)[axis], 0.01) << name;
    }
  }
  for (const char* file :
       {"trajectory/v1.tum", "trajectory/v2.cov.csv", "map.ply", "map_2d.pgm", "graph.g2o",
        "degeneracy/v1.csv", "rounds.csv", "loops.csv", "ranges.csv", "report.html", "session.mcap",
        "settings.yaml", "evaluation.json", "keyframes/v2/000000.pcd"}) {
    EXPECT_TRUE(fs::exists(folder_.path("told/" + std::string(file)))) << file;
  }
  EXPECT_FALSE(fs::exists(folder_.path("told/odometry")));
  EXPECT_FALSE(fs::exists(folder_.path("told/live")));
  const auto metrics = nlohmann::json::parse(folder_.read("told/metrics.json"));
  EXPECT_EQ(metrics["status"], "complete");
  EXPECT_EQ(metrics["fleet"]["groups"].size(), 1U);
  EXPECT_GT(metrics["ranges"]["used"], 0);
  EXPECT_TRUE(metrics["vehicles"]["v1"]["live"].is_null());
}

TEST_F(MapStates, the_output_is_independent_of_order_and_distribution_of_the_facts) {
  const std::vector<std::vector<std::string>> inputs = {
      {at("v1"), at("v2")}, {at("v2"), at("v1")}, {at("all")}, {at("all"), at("v2")}};
  std::vector<std::string> outs;
  for (const auto& folders : inputs) {
    outs.push_back(fmt::format("out{}", outs.size()));
    std::vector<std::string> words = folders;
    words.push_back(at("sim/fleet.yaml"));  // at any position
    const Outcome done = map(outs.back(), words, {"--no-report"});
    ASSERT_EQ(done.code, 0) << done.err;
  }
  for (const char* file : {"trajectory/v1.tum", "trajectory/v2.tum", "trajectory/v2.cov.csv",
                           "map.ply", "keyframes.csv", "graph.g2o", "ranges.csv", "metrics.json",
                           "settings.yaml", "session.mcap"}) {
    const std::string first = folder_.read(outs[0] + '/' + file);
    EXPECT_FALSE(first.empty()) << file;
    for (const std::string& out : outs) {
      EXPECT_TRUE(folder_.read(out + '/' + file) == first) << out << ' ' << file;
    }
  }
}

TEST_F(MapStates, mapping_does_not_change_the_state_folders) {
  const auto listing = [](const std::string& folder) {
    std::map<std::string, std::uintmax_t> files;
    for (const auto& entry : fs::directory_iterator(folder)) {
      files[entry.path().filename().string()] = fs::file_size(entry.path());
    }
    return files;
  };
  const auto before = listing(at("v1"));
  ASSERT_EQ(map("out", {at("v1")}, {"--no-report", "--no-mcap"}).code, 0);
  EXPECT_EQ(listing(at("v1")), before);
}

TEST_F(MapStates, a_damaged_fact_log_exits_with_3_and_a_truncated_with_0) {
  fs::copy(at("v1"), folder_.path("damaged"));
  const std::string log = folder_.path("damaged/facts-000000.log");
  const auto size = fs::file_size(log);
  fs::resize_file(log, size - 3);  // truncated: the loss is not detectable
  const Outcome torn = map("torn", {folder_.path("damaged")}, {"--no-report", "-v"});
  EXPECT_EQ(torn.code, 0) << torn.err;
  EXPECT_NE(torn.err.find("are no whole record and were left out"), std::string::npos) << torn.err;
  {
    std::fstream file(log, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(size / 2));
    file.write("\0\0\0\0", 4);
  }
  const Outcome damaged = map("damaged_out", {folder_.path("damaged")}, {"--no-report"});
  EXPECT_EQ(damaged.code, 3) << damaged.err;
  EXPECT_NE(damaged.err.find("are damaged"), std::string::npos) << damaged.err;
  EXPECT_NE(damaged.err.find("v1: 1 of "), std::string::npos) << damaged.err;
}

TEST_F(MapStates, invalid_inputs_are_refused_before_anything_is_written) {
  fs::create_directories(folder_.path("empty"));
  const std::string stranger =
      folder_.write("other.yaml", "vehicles: {red: {live: {address: 127.0.0.1}}, v2: {}}\n");

  struct Case {
    std::vector<std::string> words;
    std::string sentence;
  };

  const std::vector<Case> cases = {
      {{at("v1"), at("sim/v2.bag")}, "there is no such folder"},
      {{at("v1"), at("sim/fleet.yaml"), stranger}, "is a second fleet.yaml"},
      {{at("v1"), folder_.path("empty")},
       "is no state folder of a vehicle (facts-*.log). Give the"},
      {{folder_.path("empty")}, "holds neither a recording"},
      {{at("v1"), stranger}, "vehicle 1 of its fleet is 'v1', that of"},
      {{at("v1"), "--start", "1"}, "--start: is for recordings"},
      {{at("v1"), "--ranges", "r.csv"}, "--ranges: is for recordings"}};
  for (const Case& c : cases) {
    const Outcome done = map("none", c.words);
    EXPECT_EQ(done.code, 2) << done.err;
    EXPECT_NE(done.err.find(c.sentence), std::string::npos) << done.err;
    EXPECT_EQ(std::count(done.err.begin(), done.err.end(), '\n'), 1) << done.err;
  }
  EXPECT_FALSE(fs::exists(folder_.path("none")));
}

TEST_F(MapStates, a_recording_among_state_folders_is_refused) {
  std::string recording;
  for (const auto& entry : fs::directory_iterator(at("sim"))) {
    const auto extension = entry.path().extension();
    if (extension == ".mcap" || extension == ".bag") recording = entry.path().string();
  }
  ASSERT_FALSE(recording.empty());
  const Outcome done = map("none", {at("v1"), recording});
  EXPECT_EQ(done.code, 2);
  EXPECT_NE(done.err.find("is no state folder of a vehicle, as others of the inputs are"),
            std::string::npos)
      << done.err;
  const Outcome info = run_rali({"info", at("v1")});
  EXPECT_EQ(info.code, 2);
  EXPECT_NE(info.err.find("is the state folder of a live vehicle"), std::string::npos) << info.err;
}

}  // namespace
}  // namespace rali::cli
