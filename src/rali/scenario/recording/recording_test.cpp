#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include <gtest/gtest.h>

#include "rali/config/load_fleet.hpp"
#include "rali/io/files/mesh_file.hpp"
#include "rali/io/files/range_csv.hpp"
#include "rali/io/files/tum.hpp"
#include "rali/io/message_source.hpp"
#include "rali/scenario/recording/write_recording.hpp"
#include "rali/wire/decode.hpp"

namespace rali::scenario {
namespace {

namespace fs = std::filesystem;

/// A temporary folder, removed at the end.
class Folder {
 public:
  Folder() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    path_ = fs::temp_directory_path() / ("rali_recording_" + std::string(test->name()));
    fs::remove_all(path_);
  }

  ~Folder() { fs::remove_all(path_); }

  [[nodiscard]] std::string operator/(const std::string& name) const {
    return (path_ / name).string();
  }

  [[nodiscard]] std::string text() const { return path_.string(); }

 private:
  fs::path path_;
};

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Contents of every file below a folder.
std::map<std::string, std::string> contents(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files[fs::relative(entry.path(), folder).string()] = bytes_of(entry.path());
    }
  }
  return files;
}

/// Two vehicles in the hall with a coarse LiDAR for a short time.
std::unique_ptr<sim::FleetSimulation> fleet(int vehicles = 2, double duration_s = 0.6) {
  sim::FleetOptions o;
  o.vehicles = vehicles;
  o.vehicle.duration_s = duration_s;
  o.vehicle.imu_apart = true;
  auto world = sim::world_for(sim::make_world(sim::Scene::kCorridor, 1), vehicles);
  EXPECT_TRUE(world.has_value());
  auto made = sim::make_fleet_simulation(std::move(*world), o);
  EXPECT_TRUE(made.has_value()) << made.error().message();
  return std::move(*made);
}

RecordingOptions into(const Folder& folder, RecordingFormat format = RecordingFormat::kMcap) {
  EXPECT_TRUE(prepare_recording_folder(folder.text(), true).has_value());
  RecordingOptions o;
  o.folder = folder.text();
  o.format = format;
  o.title = "corridor";
  o.scene_yaml = "scene: corridor\n";
  return o;
}

bool go_on(double /*share*/) { return true; }

RecordingSummary written(const RecordingOptions& options, int vehicles = 2,
                         double duration_s = 0.6) {
  const auto sim = fleet(vehicles, duration_s);
  const auto summary = write_recording(*sim, options, go_on);
  EXPECT_TRUE(summary.has_value()) << summary.error().message();
  return summary.value_or(RecordingSummary{});
}

/// Messages of a recording by topic; `damaged`: whether the reader reported damage.
std::map<std::string, int> messages_in(const std::string& path, bool* damaged = nullptr) {
  std::map<std::string, int> counts;
  auto source = io::open_recording(path);
  EXPECT_TRUE(source.has_value()) << source.error().message();
  if (!source) return counts;
  io::RawMessage message;
  Result<bool> more = true;
  while ((more = (*source)->next(message)) && *more) {
    ++counts[(*source)->topics()[message.topic].name];
  }
  const io::SourceHealth& health = (*source)->health();
  if (damaged != nullptr) {
    *damaged = !more || health.truncated || health.messages_skipped > 0 || !health.findings.empty();
  }
  return counts;
}

TEST(Recording, has_every_file_and_no_other) {
  const Folder folder;
  (void)written(into(folder));
  std::vector<std::string> names;
  for (const auto& [name, bytes] : contents(folder.text())) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"fleet.yaml", "radio.csv", "ranges.csv", "scene.yaml",
                                             "simulation.json", "truth/biases.csv",
                                             "truth/mesh.ply", "truth/ranges.csv", "truth/v1.tum",
                                             "truth/v2.tum", "v1.mcap", "v2.mcap"}));
}

TEST(Recording, of_one_vehicle_has_no_ranges) {
  const Folder folder;
  const RecordingSummary summary = written(into(folder), 1);
  EXPECT_EQ(summary.ranges, 0U);
  EXPECT_FALSE(fs::exists(folder / "ranges.csv"));
  const auto loaded = config::load_fleet(folder / "fleet.yaml", {});
  ASSERT_TRUE(loaded.has_value()) << loaded.error().message();
  EXPECT_TRUE(loaded->ranges.sources.empty());
}

TEST(Recording, all_formats_hold_the_messages_that_were_counted) {
  for (std::size_t f = 0; f < kRecordingFormatNames.size(); ++f) {
    const Folder folder;
    const auto format = static_cast<RecordingFormat>(f);
    const RecordingSummary summary = written(into(folder, format));
    ASSERT_EQ(summary.vehicles.size(), 2U);
    for (const VehicleSummary& v : summary.vehicles) {
      bool damaged = true;
      const auto counts = messages_in(folder / v.file, &damaged);
      EXPECT_FALSE(damaged) << v.file;
      EXPECT_EQ(counts.at("/rslidar_points"), static_cast<int>(v.scans)) << v.file;
      EXPECT_EQ(counts.at("/imu/data"), static_cast<int>(v.imu_samples)) << v.file;
      EXPECT_GE(v.scans, 4U);
      EXPECT_GE(v.imu_samples, 90U);
    }
  }
}

TEST(Recording, fleet_yaml_has_noisy_start_pose_priors_unless_disabled) {
  const Folder folder;
  const auto sim = fleet();
  RecordingOptions options = into(folder);
  ASSERT_TRUE(write_recording(*sim, options, go_on).has_value());
  const auto loaded = config::load_fleet(folder / "fleet.yaml", {});
  ASSERT_TRUE(loaded.has_value()) << loaded.error().message();
  ASSERT_EQ(loaded->priors.size(), 1U);
  const config::PriorConfig& prior = loaded->priors[0];
  EXPECT_EQ(prior.vehicle, "v2");
  EXPECT_EQ(prior.relative_to, "v1");
  const geometry::SE3 T_v1 = sim->truth(0, sim->t_start()).state.T_world_body;
  const geometry::SE3 T_v2 = sim->truth(1, sim->t_start()).state.T_world_body;
  const double off_m = (prior.p_m - (T_v1.inverse() * T_v2).p).norm();
  EXPECT_GT(off_m, 0.001);
  EXPECT_LT(off_m, 5.0 * prior.sigma_m);
  const Folder silent;
  options = into(silent);
  options.priors = false;
  ASSERT_TRUE(write_recording(*fleet(), options, go_on).has_value());
  EXPECT_TRUE(config::load_fleet(silent / "fleet.yaml", {})->priors.empty());
}

TEST(Recording, fleet_yaml_loads_with_the_nominal_calibration) {
  const Folder folder;
  const auto sim = fleet();
  ASSERT_TRUE(write_recording(*sim, into(folder), go_on).has_value());
  const auto loaded = config::load_fleet(folder / "fleet.yaml", {});
  ASSERT_TRUE(loaded.has_value()) << loaded.error().message();
  ASSERT_EQ(loaded->vehicles.size(), 2U);
  const auto& v2 = loaded->vehicles[1];
  EXPECT_EQ(v2.name, "v2");
  EXPECT_EQ(v2.lidar.cloud.model, "rs16");
  EXPECT_LT((v2.lidar.T_body_lidar.T.p - sim->calibration_nominal(1).T_body_lidar.p).norm(), 1e-4);
  EXPECT_GT((v2.lidar.T_body_lidar.T.p - sim->calibration_true(1).T_body_lidar.p).norm(), 1e-3);
  ASSERT_EQ(v2.antennas.size(), 1U);
  EXPECT_LT((v2.antennas[0].p_body_m - sim->antennas(1)[0].p_nominal_m).norm(), 1e-4);
  EXPECT_EQ(loaded->ranges.sources.size(), 1U);
}

TEST(Recording, ranges_csv_and_ground_truth_ranges_have_the_same_exchanges) {
  const Folder folder;
  const RecordingSummary summary = written(into(folder), 2, 1.5);
  const io::RadioNames names{{"v1", {VehicleId{0}, 0}}, {"v2", {VehicleId{1}, 0}}};
  const auto ranges = io::read_ranges_csv(folder / "ranges.csv", names);
  ASSERT_TRUE(ranges.has_value()) << ranges.error().message();
  EXPECT_EQ(ranges->samples.size(), summary.ranges);
  EXPECT_GT(summary.ranges, 20U);
  EXPECT_TRUE(ranges->findings.empty());
  const std::string truth = bytes_of(folder / "truth/ranges.csv");
  EXPECT_EQ(static_cast<std::uint64_t>(std::count(truth.begin(), truth.end(), '\n')),
            summary.ranges + 1);
  // The distance in the first row of truth equals the first range.
  const std::size_t row = truth.find('\n') + 1;
  const std::string cells = truth.substr(row, truth.find('\n', row) - row);
  const std::size_t value = cells.find("v2,");
  ASSERT_NE(value, std::string::npos) << cells;
  const double distance = std::stod(cells.substr(value + 3));
  EXPECT_NEAR(ranges->samples.front().range_m, distance, 1.0);
  EXPECT_LT(ranges->samples.front().rssi_dbm, -40.0);
  const auto radio = io::read_radio_csv(folder / "radio.csv", names);
  ASSERT_TRUE(radio.has_value()) << radio.error().message();
  EXPECT_EQ(radio->samples.size(), summary.radio_readings);
}

TEST(Recording, ground_truth_has_poses_at_100_hz_and_the_mesh) {
  const Folder folder;
  const auto sim = fleet();
  ASSERT_TRUE(write_recording(*sim, into(folder), go_on).has_value());
  const auto tum = io::read_tum(folder / "truth/v2.tum");
  ASSERT_TRUE(tum.has_value());
  ASSERT_EQ(tum->poses.size(), 61U);
  EXPECT_EQ(tum->poses[50].t, sim->t_start() + Duration::from_s(0.5));
  const auto pose = sim->truth(1, tum->poses[50].t).state.T_world_body;
  EXPECT_LT((tum->poses[50].T.p - pose.p).norm(), 2e-6);
  const auto mesh = io::read_mesh_file(folder / "truth/mesh.ply");
  ASSERT_TRUE(mesh.has_value());
  EXPECT_EQ(mesh->triangles.size(), sim->mesh().triangles.size());
}

TEST(Recording, same_seed_gives_same_bytes_for_any_order_of_blocks) {
  /// Runs blocks from the last to the first, as threads might.
  class Backwards final : public Executor {
   public:
    void for_blocks(std::size_t n, std::size_t block,
                    const std::function<void(std::size_t, std::size_t, std::size_t)>& f) override {
      for (std::size_t index = (n + block - 1) / block; index-- > 0;) {
        f(index, index * block, std::min(n, (index + 1) * block));
      }
    }
  };

  const Folder folder;
  for (const RecordingFormat format : {RecordingFormat::kMcap, RecordingFormat::kBag}) {
    (void)written(into(folder, format));
    const auto first = contents(folder.text());
    Backwards backwards;
    const auto sim = fleet();
    sim->use(backwards);
    ASSERT_TRUE(write_recording(*sim, into(folder, format), go_on).has_value());
    EXPECT_EQ(first, contents(folder.text()));
  }
}

TEST(Recording, faults_change_only_the_recordings) {
  const Folder folder;
  const auto sound = written(into(folder));
  auto before = contents(folder.text());
  RecordingOptions o = into(folder);
  o.faults = *parse_faults({"gap:v1@0.2-0.4", "uwb_off:all@0-1"}, 2);
  const auto spoilt = written(o);
  auto after = contents(folder.text());
  EXPECT_LT(spoilt.vehicles[0].scans, sound.vehicles[0].scans);
  EXPECT_EQ(spoilt.vehicles[0].scans + spoilt.vehicles[0].imu_samples + spoilt.vehicles[0].lost,
            sound.vehicles[0].scans + sound.vehicles[0].imu_samples);
  EXPECT_EQ(spoilt.ranges, 0U);
  EXPECT_EQ(before["v2.mcap"], after["v2.mcap"]);
  EXPECT_NE(before["v1.mcap"], after["v1.mcap"]);
  for (const char* name : {"truth/v1.tum", "truth/ranges.csv", "truth/biases.csv", "fleet.yaml"}) {
    EXPECT_EQ(before[name], after[name]) << name;
  }
}

TEST(Recording, a_file_with_cut_fault_is_readable_up_to_the_cut) {
  for (std::size_t f = 0; f < kRecordingFormatNames.size(); ++f) {
    const Folder folder;
    RecordingOptions o = into(folder, static_cast<RecordingFormat>(f));
    o.faults = *parse_faults({"cut_file:v1@1.2"}, 2);
    const auto summary = written(o, 2, 1.6);
    EXPECT_TRUE(summary.vehicles[0].cut);
    EXPECT_FALSE(summary.vehicles[1].cut);
    bool damaged = false;
    auto counts = messages_in(folder / summary.vehicles[0].file, &damaged);
    EXPECT_TRUE(damaged) << summary.vehicles[0].file;
    EXPECT_LT(counts["/imu/data"], 260) << summary.vehicles[0].file;
    EXPECT_GT(counts["/imu/data"], 50) << summary.vehicles[0].file;
    (void)messages_in(folder / summary.vehicles[1].file, &damaged);
    EXPECT_FALSE(damaged);
  }
}

TEST(Recording, time_field_fault_zeroes_point_times_but_not_the_header_stamp) {
  const Folder folder;
  RecordingOptions o = into(folder);
  o.faults = *parse_faults({"time_field:v1@0-9"}, 1);
  (void)written(o, 1, 0.5);
  auto source = io::open_recording(folder / "v1.mcap");
  ASSERT_TRUE(source.has_value());
  int clouds = 0;
  io::RawMessage message;
  while ((*source)->next(message).value_or(false)) {
    if ((*source)->topics()[message.topic].name != "/rslidar_points") continue;
    const auto cloud = wire::decode_point_cloud2(message.data, wire::Encoding::kCdr);
    ASSERT_TRUE(cloud.has_value());
    EXPECT_GT(cloud->stamp.ns, 1'600'000'000'000'000'000);
    for (std::size_t at = 18; at + 8 <= cloud->data.size(); at += 26 * 97) {
      double stamp = -1.0;
      std::memcpy(&stamp, cloud->data.data() + at, 8);
      ASSERT_EQ(stamp, 0.0);
    }
    ++clouds;
  }
  EXPECT_GE(clouds, 4);
}

TEST(Recording, interrupted_is_complete_up_to_the_interruption) {
  const Folder folder;
  const auto sim = fleet(2, 1.0);
  const auto summary =
      write_recording(*sim, into(folder), [](double fraction) { return fraction < 0.5; });
  ASSERT_TRUE(summary.has_value());
  EXPECT_TRUE(summary->interrupted);
  EXPECT_NEAR(summary->duration_s, 0.5, 0.12);
  bool damaged = true;
  EXPECT_GT(messages_in(folder / "v1.mcap", &damaged)["/imu/data"], 80);
  EXPECT_FALSE(damaged);
  EXPECT_NEAR(static_cast<double>(io::read_tum(folder / "truth/v1.tum")->poses.size()), 51.0, 12.0);
  EXPECT_NE(bytes_of(folder / "simulation.json").find("\"interrupted\""), std::string::npos);
}

TEST(RecordingFolder, with_files_of_other_programs_is_never_changed) {
  const Folder folder;
  ASSERT_TRUE(prepare_recording_folder(folder.text(), false).has_value());
  std::ofstream(folder / "v1.mcap") << "precious";
  const auto refused = prepare_recording_folder(folder.text(), false);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kUsage);
  const auto not_ours = prepare_recording_folder(folder.text(), true);
  ASSERT_FALSE(not_ours.has_value());
  EXPECT_EQ(bytes_of(folder / "v1.mcap"), "precious");
}

TEST(RecordingFolder, of_a_killed_run_can_be_overwritten) {
  const Folder folder;
  fs::create_directories(folder / "truth");
  fs::create_directories(folder / ".v1.tmp/v1");
  for (const char* name : {"simulation.json", ".v2.mcap.tmp", ".ranges.csv.tmp",
                           ".v1.tmp/v1/v1_0.db3", "truth/.v1.tum.tmp", "truth/mesh.ply"}) {
    std::ofstream(folder / name) << "half";
  }
  ASSERT_TRUE(prepare_recording_folder(folder.text(), true).has_value());
  EXPECT_TRUE(contents(folder.text()).empty());
  EXPECT_FALSE(fs::exists(folder / ".v1.tmp"));
}

TEST(RecordingFolder, overwriting_removes_only_what_simulate_wrote) {
  const Folder folder;
  (void)written(into(folder, RecordingFormat::kRosbag2));
  std::ofstream(folder / "notes.txt") << "mine";
  std::ofstream(folder / "v9000.mcap") << "mine";
  std::ofstream(folder / "truth/marks.csv") << "mine";
  ASSERT_TRUE(prepare_recording_folder(folder.text(), true).has_value());
  std::vector<std::string> left;
  for (const auto& [name, bytes] : contents(folder.text())) left.push_back(name);
  EXPECT_EQ(left, (std::vector<std::string>{"notes.txt", "truth/marks.csv", "v9000.mcap"}));
  EXPECT_FALSE(fs::exists(folder / "v1"));
}

}  // namespace
}  // namespace rali::scenario
