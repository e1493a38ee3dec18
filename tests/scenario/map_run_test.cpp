// Real recordings through the whole of `rali map`: from a folder of scans or a bag to the outputs.
#include "rali/drive/map_run.hpp"

#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "rali/drive/output/out_dir.hpp"
#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/io/files/tum.hpp"

namespace rali {
namespace {

namespace fs = std::filesystem;

class Quiet final : public drive::ProgressSink {
 public:
  explicit Quiet(std::atomic<bool>* stop = nullptr, double stop_after_m = 0.0)
      : stop_(stop), stop_after_m_(stop_after_m) {}

  void progress(const drive::Progress& p) override {
    if (stop_ != nullptr && p.path_m > stop_after_m_) stop_->store(true);
  }

  void finding(const Finding&) override {}

 private:
  std::atomic<bool>* stop_;
  double stop_after_m_;
};

/// Writes the first n scans of kitti_0005 as KITTI .bin with times.txt.
void write_kitti_folder(const std::string& out, int n, double period_s = 0.10356) {
  fs::create_directories(out);
  std::ofstream times(out + "/times.txt");
  times.precision(12);
  for (int i = 0; i < n; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "%06d", i);
    std::ifstream in(io::real_data("kitti_0005") + "/scans16/" + name + ".xyzir", std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
    std::vector<float> points;
    for (std::size_t at = 0; at + 8 <= bytes.size(); at += 8) {
      std::int16_t xyz[3];
      std::memcpy(xyz, bytes.data() + at, sizeof xyz);
      for (const std::int16_t v : xyz) points.push_back(static_cast<float>(v) * 0.0025F);
      points.push_back(static_cast<float>(static_cast<unsigned char>(bytes[at + 6])) / 100.0F);
    }
    std::ofstream bin(out + '/' + name + ".bin", std::ios::binary);
    bin.write(reinterpret_cast<const char*>(points.data()),
              static_cast<std::streamsize>(points.size() * sizeof(float)));
    times << 1000.0 + period_s * i << '\n';
  }
}

drive::MapJob job_of(const std::string& input, const std::string& out, int threads) {
  drive::MapJob job;
  drive::VehicleJob vehicle;
  vehicle.inputs = {input};
  job.vehicles.push_back(vehicle);
  job.out_dir = out;
  job.threads = threads;
  job.map.voxel_m = 0.2;
  return job;
}

/// All outputs but the exempt ones.
std::map<std::string, std::string> outputs(const std::string& dir) {
  std::map<std::string, std::string> files;
  const Result<std::vector<std::string>> names = drive::list_outputs(dir);
  if (!names) return files;
  for (const std::string& name : *names) {
    if (drive::is_exempt_name(name)) continue;
    std::ifstream file(dir + '/' + name, std::ios::binary);
    files[name] = {std::istreambuf_iterator<char>(file), {}};
  }
  return files;
}

TEST(MapScenario, follows_the_car_of_kitti_and_does_not_depend_on_threads) {
  RALI_NEEDS_DATA("kitti_0005");
  const io::TestFolder folder;
  write_kitti_folder(folder.path("scans"), 25);
  const std::atomic<bool> stop{false};
  Quiet sink;
  const auto one = drive::run_map(job_of(folder.path("scans"), folder.path("one"), 1), sink, stop);
  ASSERT_TRUE(one) << one.error().message();
  const auto two = drive::run_map(job_of(folder.path("scans"), folder.path("two"), 2), sink, stop);
  ASSERT_TRUE(two) << two.error().message();

  const auto files = outputs(folder.path("one"));
  EXPECT_GT(files.size(), 12U);
  for (const char* name :
       {"trajectory/v1.tum", "trajectory/v1.cov.csv", "odometry/v1.tum", "degeneracy/v1.csv",
        "map.pcd", "map.ply", "removed.pcd", "keyframes.csv", "graph.g2o", "graph.pyfg",
        "map_2d.pgm", "map_2d.yaml", "loops.csv", "session.mcap", "metrics.json"}) {
    EXPECT_TRUE(files.contains(name)) << name;
  }
  const auto others = outputs(folder.path("two"));
  ASSERT_EQ(files.size(), others.size());
  for (const auto& [name, bytes] : files) {
    EXPECT_TRUE(others.contains(name) && others.at(name) == bytes) << name << " differs";
  }
  const auto truth = io::read_tum(io::real_data("kitti_0005") + "/reference_registration.tum");
  const auto tum = io::read_tum(folder.path("one/trajectory/v1.tum"));
  ASSERT_TRUE(truth && tum);
  ASSERT_GE(tum->poses.size(), 20U);
  const std::size_t last = tum->poses.size() - 1;
  const double path_m = (tum->poses[last].T.p - tum->poses[0].T.p).norm();
  const double true_m = (truth->poses[last].T.p - truth->poses[0].T.p).norm();
  EXPECT_NEAR(path_m, true_m, 0.1 * true_m) << "a car that moves must not stand in the map";
}

TEST(MapScenario, gets_the_same_trajectory_from_every_container) {
  RALI_NEEDS_DATA("recordings/converted_pointcloud2");
  const io::TestFolder folder;
  const std::atomic<bool> stop{false};
  Quiet sink;
  std::string first;
  for (const char* file :
       {"none.bag", "bz2.bag", "lz4.bag", "none.mcap", "lz4.mcap", "zstd.mcap", "nochunk.mcap"}) {
    const std::string input =
        io::real_data("recordings/converted_pointcloud2") + "/kitti16_3scans_" + file;
    const std::string out = folder.path(file);
    const auto run = drive::run_map(job_of(input, out, 1), sink, stop);
    ASSERT_TRUE(run) << file << ": " << run.error().message();
    const std::string text = outputs(out)["trajectory/v1.tum"];
    if (first.empty()) first = text;
    EXPECT_EQ(text, first) << file;
  }
  EXPECT_EQ(io::parse_tum(first, "first")->poses.size(), 3U);
}

TEST(MapScenario, refuses_raw_packets_and_names_the_sensor) {
  RALI_NEEDS_DATA("recordings/velodyne_vlp16");
  const std::string root = io::real_data("recordings/velodyne_vlp16");
  const io::TestFolder folder;
  const std::atomic<bool> stop{false};
  Quiet sink;
  const auto run =
      drive::run_map(job_of(root + "/1673400471837873222", folder.path("out"), 1), sink, stop);
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, ErrorCode::kInput);
  EXPECT_NE(run.error().message().find("raw packets of a Velodyne, not points"), std::string::npos)
      << run.error().message();
  EXPECT_FALSE(fs::exists(folder.path("out"))) << "nothing was started";
}

TEST(MapScenario, finishes_its_outputs_when_it_is_stopped) {
  RALI_NEEDS_DATA("kitti_0005");
  const io::TestFolder folder;
  write_kitti_folder(folder.path("scans"), 30);
  std::atomic<bool> stop{false};
  Quiet sink(&stop, 1.0);
  const auto run = drive::run_map(job_of(folder.path("scans"), folder.path("out"), 1), sink, stop);
  ASSERT_TRUE(run) << run.error().message();
  EXPECT_EQ(run->status, drive::RunStatus::kInterrupted);
  EXPECT_LT(run->vehicles.at(0).scans, 30U);
  std::ifstream file(folder.path("out/status.json"));
  const auto status = nlohmann::json::parse(file);
  EXPECT_EQ(status["status"], "interrupted");
  const auto files = outputs(folder.path("out"));
  EXPECT_EQ(status["files"].size(), files.size());
  EXPECT_TRUE(files.contains("map.pcd"));
  EXPECT_TRUE(io::read_tum(folder.path("out/trajectory/v1.tum")));
}

TEST(MapScenario, leaves_readable_odometry_and_keyframes_when_it_is_killed) {
  RALI_NEEDS_DATA("kitti_0005");
  const io::TestFolder folder;
  // Twice the period, because odometry is written to disk every 10 s of data.
  write_kitti_folder(folder.path("scans"), 130, 0.2071);
  const std::string out = folder.path("out"), scans = folder.path("scans");
  const std::string odometry = out + "/odometry/.scans.tum.tmp";  // named after the folder
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    execl(RALI_BINARY, RALI_BINARY, "map", scans.c_str(), "-o", out.c_str(), "-q", nullptr);
    _exit(127);
  }
  // Killed as soon as the first 10 s of odometry are on disk, or ended by itself.
  int status = 0;
  bool ended = false;
  for (int i = 0; i < 24000 && !ended; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ended = waitpid(child, &status, WNOHANG) == child;
    std::error_code error;
    const auto size = fs::file_size(odometry, error);
    if (!error && size > 2000) break;
  }
  if (!ended) {
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
  }
  ASSERT_FALSE(ended) << "the run ended before it could be killed";
  for (const auto& entry : fs::directory_iterator(out + "/keyframes/scans")) {
    if (entry.path().filename().string().starts_with('.')) continue;
    EXPECT_TRUE(io::read_cloud_file(entry.path().string())) << entry.path();
  }
  const auto tum = io::read_tum(odometry);
  ASSERT_TRUE(tum) << tum.error().message();
  EXPECT_GE(tum->poses.size(), 20U);
  std::ifstream file(out + "/status.json");
  EXPECT_EQ(nlohmann::json::parse(file)["status"], "running");
}

}  // namespace
}  // namespace rali
