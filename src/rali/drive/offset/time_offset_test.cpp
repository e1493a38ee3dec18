#include "rali/drive/offset/time_offset.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/drive/hall_recording_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::drive {
namespace {

imu::RotationStudy study_of(double offset_s, double sigma_s) {
  imu::RotationStudy study;
  study.turned_rad = 6.0;
  study.time_offset_s = offset_s;
  study.time_offset_sigma_s = sigma_s;
  return study;
}

TEST(TimeOffset, is_applied_only_if_certain_and_significant) {
  EXPECT_EQ(judge_time_offset(study_of(0.0381, 0.001), 20.0).value_s, 0.0381);
  EXPECT_EQ(judge_time_offset(study_of(-0.0381, 0.001), 20.0).value_s, -0.0381);
  const LidarTimeOffset small = judge_time_offset(study_of(0.0099, 0.0005), 20.0);
  EXPECT_EQ(small.value_s, 0.0) << "below 10 ms nothing is gained";
  EXPECT_EQ(small.estimate_s, 0.0099);
  EXPECT_NE(small.origin.find("not significant"), std::string::npos) << small.origin;
  EXPECT_EQ(judge_time_offset(study_of(0.015, 0.004), 20.0).value_s, 0.0) << "below 4 sigma";
  EXPECT_EQ(judge_time_offset(study_of(0.1, 0.011), 20.0).value_s, 0.0) << "sigma too large";
}

TEST(TimeOffset, reports_why_it_was_not_estimated) {
  imu::RotationStudy none;
  none.turned_rad = 0.2;
  EXPECT_NE(judge_time_offset(none, 60.0).origin.find("11 deg of turning in 60 s"),
            std::string::npos);
  imu::RotationStudy loose = none;
  loose.turned_rad = 19.0;
  loose.time_offset_sigma_s = 0.023;
  EXPECT_EQ(judge_time_offset(loose, 60.0).origin,
            "not estimated: sigma 23 ms after 1089 deg of turning in 60 s");
  imu::RotationStudy border = study_of(0.3, 0.001);
  border.offset_at_border = true;
  const LidarTimeOffset at_border = judge_time_offset(border, 60.0);
  EXPECT_EQ(at_border.value_s, 0.0);
  EXPECT_FALSE(at_border.estimate_s.has_value());
  EXPECT_NE(at_border.origin.find("0.3 s"), std::string::npos);
}

const geometry::Mat3 kAligned = geometry::Mat3::Identity();

VehicleJob job_of(const std::string& path) {
  VehicleJob job;
  job.inputs = {path};
  job.input.vehicle = "v1";
  job.find_time_offset = true;
  return job;
}

TEST(TimeOffset, is_estimated_for_a_lidar_that_is_40_ms_early) {
  const io::TestFolder folder;
  test::HallRecording recording;
  recording.duration_s = 8.0;
  recording.lidar_shift_s = -0.040;
  const std::string path = recording.write(folder.path("v1.bag"));
  SerialExecutor serial;
  double seen = 0.0;
  const LidarTimeOffset offset =
      study_turning_of(job_of(path), kAligned, serial, false, [&](double fraction) {
        seen = fraction;
        return true;
      }).offset;
  EXPECT_NEAR(offset.value_s, 0.040, 0.003) << offset.origin;
  ASSERT_TRUE(offset.sigma_s.has_value());
  EXPECT_LT(*offset.sigma_s, 0.008) << "eight seconds of turning";
  EXPECT_LT(std::abs(offset.value_s - 0.040), *offset.sigma_s);
  EXPECT_GT(seen, 0.1);
  const LidarTimeOffset again =
      study_turning_of(job_of(path), kAligned, serial, true, [](double) { return true; }).offset;
  EXPECT_EQ(again.estimate_s, offset.estimate_s) << "reading ahead must not change a bit";
}

TEST(TimeOffset, is_not_estimated_if_stopped_or_the_recording_is_unreadable) {
  const io::TestFolder folder;
  test::HallRecording recording;
  recording.duration_s = 2.0;
  const std::string path = recording.write(folder.path("v1.bag"));
  SerialExecutor serial;
  int asked = 0;
  const LidarTimeOffset stopped =
      study_turning_of(job_of(path), kAligned, serial, false, [&](double) {
        return ++asked < 5;
      }).offset;
  EXPECT_EQ(asked, 5);
  EXPECT_NE(stopped.origin.find("stopped"), std::string::npos);
  const LidarTimeOffset none =
      study_turning_of(job_of(folder.path("none.bag")), kAligned, serial, false, [](double) {
        return true;
      }).offset;
  EXPECT_EQ(none.value_s, 0.0);
  EXPECT_NE(none.origin.find("cannot be read"), std::string::npos);
}

}  // namespace
}  // namespace rali::drive
