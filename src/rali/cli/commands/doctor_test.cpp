#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/cli/command.hpp"
#include "rali/cli/run_for_test.hpp"
#include "rali/drive/hall_recording_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

std::string hall(const io::TestFolder& folder, const std::string& name) {
  drive::test::HallRecording recording;
  recording.duration_s = 2.0;
  return recording.write(folder.path(name));
}

void write_scans(const io::TestFolder& folder, const std::string& dir) {
  std::filesystem::create_directories(folder.path(dir));
  for (int i = 0; i < 3; ++i) {
    std::string pcd =
        "VERSION .7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
        "WIDTH 720\nHEIGHT 1\nPOINTS 720\nDATA ascii\n";
    for (int k = 0; k < 720; ++k) {
      const double a = 0.00872665 * k;
      pcd += fmt::format("{} {} 0.2 1\n", 8.0 * std::cos(a), 8.0 * std::sin(a));
    }
    folder.write(fmt::format("{}/{}.pcd", dir, i), pcd);
  }
}

TEST(DoctorCommand, examines_every_recording_and_the_ranges_of_a_fleet) {
  const io::TestFolder f;
  hall(f, "a.bag");
  hall(f, "b.bag");
  write_scans(f, "scans");
  std::string imu = "stamp_s,gx,gy,gz,ax,ay,az\n", ranges = "stamp_s,from,to,range_m\n";
  for (int i = 0; i < 40; ++i) {
    imu += fmt::format("{},0,0,0,0,0,1\n", 0.01 * i);
    ranges += fmt::format("{},v1,v2,{}\n{},v2,v1,{}\n", 0.1 * i, 5.0 + 0.001 * i, 0.1 * i + 0.01,
                          5.5 + 0.001 * i);
  }
  f.write("imu_of_v2.csv", imu);
  f.write("ranges.csv", ranges);
  const std::string fleet = f.write("fleet.yaml",
                                    "vehicles:\n  v1: {recording: [a.bag, b.bag]}\n"
                                    "  v2: {recording: scans, imu: {file: imu_of_v2.csv}}\n"
                                    "ranges: {sources: [{file: ranges.csv}]}\n");
  const Outcome run = run_rali({"doctor", fleet, "-q"});
  for (const char* word : {"a.bag:", "b.bag:", "scans:", "imu_of_v2.csv", "unit is g",
                           "D14 v1->v2: 40 ranges", "warning D15 v1->v2 is -0.5"}) {
    EXPECT_NE(run.out.find(word), std::string::npos) << word << '\n' << run.out;
  }
  const Outcome as_json = run_rali({"doctor", fleet, "-q", "--json"});
  const auto json = nlohmann::json::parse(as_json.out);
  ASSERT_EQ(json["vehicles"].size(), 3U);
  EXPECT_EQ(json["vehicles"][1]["vehicle"], "v1");
  EXPECT_TRUE(json["findings"][0].contains("remedy"));
  const Outcome one = run_rali({"doctor", f.path("a.bag"), "-q", "--json"});
  EXPECT_EQ(nlohmann::json::parse(one.out)["vehicles"].size(), 1U) << "the same shape";
}

/// Checks that map and doctor reject a fleet.yaml with the same sentence.
void expect_same_refusal(const io::TestFolder& f, const std::string& name, const std::string& yaml,
                         const std::string& word) {
  const std::string fleet = f.write(name, yaml);
  const Outcome map = run_rali({"map", fleet, "-o", f.path("out"), "-q"});
  const Outcome doctor = run_rali({"doctor", fleet, "-q"});
  EXPECT_EQ(map.code, 2) << name;
  EXPECT_EQ(doctor.code, 2) << name << '\n' << doctor.out;
  EXPECT_EQ(doctor.err, map.err) << name;
  EXPECT_NE(doctor.err.find(word), std::string::npos) << doctor.err;
}

TEST(DoctorCommand, refuses_the_same_fleet_files_as_map) {
  const io::TestFolder f;
  hall(f, "a.bag");
  f.write("port.log", "x");
  f.write("imu.csv", "stamp_s,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,1\n");
  const std::string v1 = "vehicles: {v1: {recording: a.bag}}\n";
  expect_same_refusal(f, "port.yaml",
                      v1 + "ranges: {sources: [{serial_log: port.log, vehicle: v1}]}\n",
                      "Record rows of `stamp_s,hex`");
  expect_same_refusal(f, "csv.yaml", v1 + "ranges: {sources: [{file: none.csv}]}\n",
                      "there is no such file. It is named at");
  expect_same_refusal(f, "imu.yaml", "vehicles: {v1: {recording: a.bag, imu: {file: imu.csv}}}\n",
                      "--imu is for folders of scans");
  expect_same_refusal(f, "none.yaml", "vehicles: {v1: {recording: none.bag}}\n", "none.bag");
}

TEST(DoctorCommand, warns_of_a_range_topic_that_no_recording_has) {
  const io::TestFolder f;
  drive::test::HallRecording recording;
  recording.duration_s = 2.0;
  recording.range_topic = "/uwb";
  static_cast<void>(recording.write(f.path("a.bag")));
  hall(f, "b.bag");
  const std::string fleet = f.write("fleet.yaml",
                                    "vehicles: {v1: {recording: a.bag}, v2: {recording: b.bag}}\n"
                                    "ranges: {sources: [{topic: /uwb}, {topic: /uwb_rear}]}\n");
  const Outcome doctor = run_rali({"doctor", fleet, "-q"});
  const std::string sentence = "ranges.no_topic no recording has ranges on /uwb_rear\n";
  EXPECT_NE(doctor.out.find("warning " + sentence), std::string::npos) << doctor.out;
  EXPECT_NE(doctor.out.find("D14 v1->v2: 19 ranges"), std::string::npos) << doctor.out;
  EXPECT_EQ(doctor.out.find("ranges on /uwb\n"), std::string::npos) << "that one is there";
  // If only a part is examined, the index lists the later topics.
  const Outcome part = run_rali({"doctor", fleet, "-q", "--seconds", "0.05"});
  EXPECT_NE(part.out.find(sentence), std::string::npos) << part.out;
  EXPECT_EQ(part.out.find("ranges on /uwb\n"), std::string::npos) << part.out;
}

/// The error of map, doctor and info for an input, if all three agree.
std::string refusal(const io::TestFolder& f, const std::string& input) {
  const Outcome map = run_rali({"map", input, "-o", f.path("out"), "-q"});
  for (const char* command : {"doctor", "info"}) {
    const Outcome other = run_rali({command, input, "-q"});
    EXPECT_EQ(other.code, map.code) << command << ' ' << input;
    EXPECT_EQ(other.err, map.err) << command;
  }
  return fmt::format("{} {}", map.code, map.err);
}

TEST(Commands, refuse_the_same_inputs_with_the_same_message) {
  const io::TestFolder f;
  std::filesystem::create_symlink(f.path("loop.bag"), f.path("loop.bag"));
  write_scans(f, "mixed");
  f.write("mixed/9.ply", "x");
  write_scans(f, "both");
  f.write("both/v1.bag", "x");
  write_scans(f, "words");
  f.write("words/times.txt", "1\nnoon\n3\n");
  write_scans(f, "back");
  f.write("back/times.txt", "3\n2\n1\n");
  std::filesystem::create_directories(f.path("none"));
  std::filesystem::create_directories(f.path("rubbish"));
  f.write("rubbish/0.pcd", "x");
  for (const char* name :
       {"loop.bag", "mixed", "both", "words", "back", "none", "rubbish", "missing.bag"}) {
    EXPECT_EQ(refusal(f, f.path(name)).substr(0, 15), "2 rali: error: ") << name;
  }
}

}  // namespace
}  // namespace rali::cli
