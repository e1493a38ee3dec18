// `rali map` on damaged input and on a full disk: exit codes of the table, and remaining files.

#include <filesystem>
#include <fstream>
#include <functional>

#include <gtest/gtest.h>

#include "rali/cli/app.hpp"
#include "rali/cli/run_for_test.hpp"
#include "rali/drive/hall_recording_for_test.hpp"
#include "rali/io/containers/mcap_writer.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/size_limit_for_test.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/io/message_source.hpp"

namespace rali::cli {
namespace {

namespace fs = std::filesystem;
using drive::test::HallRecording;

Outcome map_it(const std::string& input, const std::string& out, bool session_file = false) {
  std::vector<std::string> words = {"map", input, "-o", out, "--threads", "1"};
  if (!session_file) words.emplace_back("--no-mcap");
  return run_rali(words);
}

HallRecording short_recording() {
  HallRecording recording;
  recording.duration_s = 3.0;
  return recording;
}

/// Scans as KITTI files; the last of them ends in the middle of a point.
std::string write_cut_folder(const io::TestFolder& folder) {
  const std::string scans = folder.path("scans");
  fs::create_directories(scans);
  const HallRecording recording;
  Rng rng(1, "lidar");
  for (int i = 0; i < 12; ++i) {
    const sensor::LidarScan scan = recording.scan(0, rng);
    std::ofstream file(scans + "/00" + std::to_string(10 + i) + ".bin", std::ios::binary);
    for (std::size_t k = 0; k < scan.size(); ++k) {
      const float point[] = {scan.x_m[k], scan.y_m[k], scan.z_m[k], scan.intensity[k]};
      const bool cut = i == 11 && k > scan.size() / 2;
      file.write(reinterpret_cast<const char*>(point), cut ? 7 : sizeof point);
      if (cut) break;
    }
  }
  return scans;
}

struct Damage {
  std::string name;
  std::function<std::string(const io::TestFolder&)> make;  ///< returns the input
  int code;
  std::string reported;  ///< in the summary or the warnings
};

std::string recorded(const io::TestFolder& folder, const HallRecording& recording) {
  return recording.write(folder.path("v1.bag"));
}

/// The same messages in a properly closed MCAP.
void recorded_mcap(const std::string& bag, const std::string& path) {
  const auto source = io::open_recording(bag);
  ASSERT_TRUE(source);
  io::MemorySink sink;
  io::McapWriter writer(sink, {"ros1"});
  std::vector<std::uint16_t> channels;
  for (const io::Topic& topic : (*source)->topics()) {
    const auto schema = writer.add_schema(topic.type, "ros1msg", topic.definition);
    channels.push_back(writer.add_channel(*schema, topic.name, "ros1").value());
  }
  io::RawMessage message;
  while ((*source)->next(message).value_or(false)) {
    ASSERT_TRUE(
        writer.write(channels[message.topic], message.t_record, message.t_record, message.data));
  }
  ASSERT_TRUE(writer.close());
  ASSERT_TRUE(io::write_file_atomic(path, std::span<const std::byte>(sink.bytes())));
}

std::vector<Damage> damages() {
  return {
      {"whole", [](const auto& f) { return recorded(f, short_recording()); }, 0, "gaps: none"},
      {"cut file",
       [](const auto& f) {
         const std::string path = recorded(f, short_recording());
         fs::resize_file(path, fs::file_size(path) * 3 / 4);
         return path;
       },
       3, "record ends after the file"},
      {"grown by zeros",
       [](const auto& f) {
         const std::string path = recorded(f, short_recording());
         fs::resize_file(path, 10ULL << 30);
         return path;
       },
       3, "nothing but zeros to the end"},
      {"closed MCAP grown by zeros",
       [](const auto& f) {
         const std::string path = f.path("v1.mcap");
         recorded_mcap(recorded(f, short_recording()), path);
         fs::resize_file(path, 10ULL << 30);
         return path;
       },
       3, "nothing but zeros to the end"},
      {"missing scans",
       [](const auto& f) {
         HallRecording recording = short_recording();
         recording.gap_from = 15;
         recording.gap_scans = 6;
         return recorded(f, recording);
       },
       0, "s without scans"},
      {"NaN points",
       [](const auto& f) {
         HallRecording recording = short_recording();
         recording.nan_fraction = 0.3;
         return recorded(f, recording);
       },
       0, "gaps: none"},
      {"clock jump",
       [](const auto& f) {
         HallRecording recording = short_recording();
         recording.jump_at_s = 2.0;
         recording.jump_s = 500.0;
         return recorded(f, recording);
       },
       0, "clock jumps closed"},
      {"one scan of a folder cut", write_cut_folder, 3, ""},
      {"no message",
       [](const auto& f) {
         HallRecording recording = short_recording();
         recording.duration_s = 0.0;
         return recorded(f, recording);
       },
       2, "rali: error: "},
      {"no byte", [](const auto& f) { return f.write("v1.bag", ""); }, 2, "rali: error: "},
  };
}

TEST(MapDamage, of_each_kind_gives_its_documented_exit_code) {
  for (const Damage& damage : damages()) {
    const io::TestFolder folder;
    const Outcome outcome = map_it(damage.make(folder), folder.path("out"));
    EXPECT_EQ(outcome.code, damage.code) << damage.name << '\n' << outcome.out << outcome.err;
    EXPECT_NE((outcome.out + outcome.err).find(damage.reported), std::string::npos)
        << damage.name << '\n'
        << outcome.out << outcome.err;
    const bool started = damage.code != 2;
    EXPECT_EQ(fs::exists(folder.path("out/map.pcd")), started) << damage.name;
    EXPECT_EQ(fs::exists(folder.path("out")), started) << damage.name;
  }
}

TEST(MapDamage, without_any_pose_reports_no_expected_position_error) {
  const io::TestFolder folder;
  HallRecording recording = short_recording();
  recording.nan_fraction = 1.0;
  const std::string input = recorded(folder, recording);
  const Outcome outcome = map_it(input, folder.path("out"));
  EXPECT_EQ(outcome.code, 3) << outcome.out << outcome.err;
  EXPECT_EQ(outcome.out.find("expected position error"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("degenerate:"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.err.find("no pose from 0 scans. See rali doctor"), std::string::npos)
      << outcome.err;
  EXPECT_NE(folder.read("out/metrics.json").find("\"sigma_max_m\": null"), std::string::npos);
  const Outcome asked = run_rali(
      {"map", input, "-o", folder.path("asked"), "--no-mcap", "--require", "max_sigma_m=0.5"});
  EXPECT_EQ(asked.code, 1) << asked.err;
  EXPECT_NE(asked.err.find("v1 has no pose"), std::string::npos) << asked.err;
}

TEST(MapDamage, a_full_disk_exits_with_4_and_leaves_no_temporary_files) {
  const io::TestFolder folder;
  const std::string input = recorded(folder, short_recording());
  Outcome outcome;
  {
    const io::FileSizeLimit limit(60'000);
    outcome = map_it(input, folder.path("out"), true);
  }
  EXPECT_EQ(outcome.code, 4) << outcome.err;
  EXPECT_NE(folder.read("out/status.json").find("\"status\": \"failed\""), std::string::npos);
  for (const auto& entry : fs::recursive_directory_iterator(folder.path("out"))) {
    EXPECT_FALSE(entry.path().filename().string().ends_with(".tmp")) << entry.path();
  }
}

TEST(MapDamage, a_report_that_cannot_be_written_leaves_a_failed_status) {
  const io::TestFolder folder;
  const std::string input = recorded(folder, short_recording());
  ASSERT_EQ(map_it(input, folder.path("out")).code, 0);
  fs::remove(folder.path("out/report.html"));
  fs::create_directories(folder.path("out/report.html/mine"));
  const Outcome again =
      run_rali({"map", input, "-o", folder.path("out"), "--no-mcap", "--overwrite"});
  EXPECT_EQ(again.code, 4) << again.err;
  EXPECT_NE(folder.read("out/status.json").find("\"failed\""), std::string::npos);
  EXPECT_NE(folder.read("out/run.log").find("error: "), std::string::npos);
}

TEST(MapDamage, an_output_path_below_a_file_exits_with_2) {
  const io::TestFolder folder;
  folder.write("file", "mine");
  const Outcome outcome = map_it(recorded(folder, short_recording()), folder.path("file/out"));
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("is a file, not a folder"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace rali::cli
