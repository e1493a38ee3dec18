#include "rali/drive/map_run.hpp"

#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/base/internal_error.hpp"
#include "rali/drive/hall_recording_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::drive {
namespace {

class SilentSink final : public ProgressSink {
 public:
  void progress(const Progress& /*progress*/) override {}

  void finding(const Finding& /*finding*/) override {}
};

/// A run over a short drive whose settings cannot be written for a fault in the program.
MapJob faulty_job(const io::TestFolder& folder) {
  test::HallRecording recording;
  recording.duration_s = 1.0;
  MapJob job;
  job.vehicles.emplace_back();
  job.vehicles.back().inputs = {recording.write(folder.path("v1.bag"))};
  job.out_dir = folder.path("out");
  job.write_mcap = false;
  job.settings_text = [](const std::vector<InputReport>& /*reports*/) -> std::string {
    throw InternalError("x > 0 at somewhere.cpp:7");
  };
  return job;
}

TEST(MapRun, an_internal_fault_leaves_a_log_and_a_status_that_says_so) {
  const io::TestFolder folder;
  SilentSink sink;
  const std::atomic<bool> stop{false};
  EXPECT_THROW(static_cast<void>(run_map(faulty_job(folder), sink, stop)), InternalError)
      << "the caller makes exit code 5 of it";
  const std::string log = folder.read("out/run.log");
  EXPECT_NE(log.find("internal fault: x > 0 at somewhere.cpp:7"), std::string::npos) << log;
  const auto status = nlohmann::json::parse(folder.read("out/status.json"));
  EXPECT_EQ(status["status"], "failed");
  EXPECT_TRUE(status["files"].contains("trajectory/v1.tum")) << "what is whole is kept";
}

TEST(MapRun, a_fault_before_the_folder_is_touched_leaves_it_alone) {
  const io::TestFolder folder;
  MapJob job = faulty_job(folder);
  job.vehicles.front().inputs = {folder.path("none.bag")};
  SilentSink sink;
  const std::atomic<bool> stop{false};
  EXPECT_FALSE(run_map(job, sink, stop));
  EXPECT_FALSE(std::filesystem::exists(folder.path("out")));
}

}  // namespace
}  // namespace rali::drive
