// `rali doctor` on simulated recordings: it reports each fault that one recording can reveal, and a
// recording without a fault has no warning.

#include <cstdio>
#include <ostream>
#include <sstream>

#include <gtest/gtest.h>

#include "rali/cli/app.hpp"
#include "rali/cli/command.hpp"
#include "rali/cli/run_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

/// The doctor's report on a scene with one vehicle.
std::string examined(const std::string& scene, const std::string& duration_s,
                     const std::string& fault) {
  const io::TestFolder folder;
  std::vector<std::string> words{
      "simulate", scene, "-o", folder.path("s"), "--vehicles", "1", "--duration", duration_s, "-q"};
  if (!fault.empty()) words.insert(words.end(), {"--fault", fault});
  const Outcome made = run_rali(words);
  EXPECT_EQ(made.code, kExitDone) << made.err;
  const Outcome run = run_rali({"doctor", folder.path("s/fleet.yaml"), "-q"});
  EXPECT_TRUE(run.code == kExitDone || run.code == kExitBelowAsked) << run.err;
  return run.out;
}

/// The warnings and errors of a report.
std::vector<std::string> complaints(const std::string& report) {
  std::vector<std::string> out;
  std::istringstream lines(report);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("warning") || line.starts_with("error")) out.push_back(line);
  }
  return out;
}

struct Case {
  std::string fault, id, words;
};

/// Prints the fault in a test's name instead of the bytes of the struct.
void PrintTo(const Case& c, std::ostream* out) { *out << c.fault << ' ' << c.id; }

class DoctorNames : public testing::TestWithParam<Case> {};

TEST_P(DoctorNames, the_fault) {
  const Case& fault = GetParam();
  const std::string report = examined("floor", "12", fault.fault);
  bool named = false;
  for (const std::string& line : complaints(report)) {
    named |= line.find(' ' + fault.id + ' ') != std::string::npos &&
             line.find(fault.words) != std::string::npos;
  }
  EXPECT_TRUE(named) << fault.fault << '\n' << report;
}

INSTANTIATE_TEST_SUITE_P(
    Faults, DoctorNames,
    testing::Values(Case{"drop:v1@4-8", "D01", "of the scans are missing"},
                    Case{"drop:v1@4-8", "D10", "of the inertial samples are missing"},
                    Case{"gap:v1@5-7", "D01", "longest gap 2."},
                    Case{"gap:v1@5-7", "D10", "longest gap 2."},
                    Case{"clock_jump:v1@5-8", "D04", "2 jumps of the clock"},
                    Case{"nan:v1@4-8", "D05", "jumps from 0 to 33 %"},
                    Case{"time_field:v1@4-8", "D02", "40 scans whose point times"},
                    Case{"time_field:v1@0-12", "D02", "'timestamp' is 0 in every point"},
                    Case{"imu_scale:v1@4-8", "D08", "its scale is off"},
                    Case{"imu_scale:v1@0-12", "D08", "its scale is off"},
                    Case{"imu_saturate:v1@4-12", "D10", "are at the end of the sensor's range"},
                    Case{"imu_saturate:v1@0-12", "D10", "are at the end of the sensor's range"},
                    Case{"cut_file:v1@8", "D19", "record ends after the file"}),
    [](const testing::TestParamInfo<Case>& test) {
      const std::string& fault = test.param.fault;
      return fault.substr(0, fault.find(':')) + '_' + test.param.id + '_' +
             std::to_string(test.index);
    });

class DoctorIsContent : public testing::TestWithParam<const char*> {};

TEST_P(DoctorIsContent, with_a_recording_without_fault) {
  for (const char* duration_s : {"8"}) {
    const std::string report = examined(GetParam(), duration_s, "");
    for (const std::string& line : complaints(report)) ADD_FAILURE() << line << '\n' << report;
    EXPECT_NE(report.find("standstill at the start"), std::string::npos) << report;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, DoctorIsContent,
                         testing::Values("loop", "corridor", "floor", "yard", "tunnel"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace rali::cli
