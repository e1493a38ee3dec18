#include "rali/inspect/imu_study.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "rali/imu/turning_for_test.hpp"

namespace rali::inspect {
namespace {

/// Two seconds of standstill, then driving with turns and vibration.
std::vector<sensor::ImuSample> drive_off(double shake_mps2 = 0.1) {
  std::vector<sensor::ImuSample> samples;
  Rng rng(9, "imu");
  for (int i = 0; i < 2000; ++i) {
    const double t = i * 0.005;
    const bool moves = t > 2.0;
    const geometry::Vec3 n{rng.normal(), rng.normal(), rng.normal()};
    const geometry::Vec3 m{rng.normal(), rng.normal(), rng.normal()};
    sensor::ImuSample s{Time::from_s(100.0 + t), 0.002 * n,
                        geometry::Vec3{0.0, 0.0, 9.81} + 0.02 * m};
    if (moves) s.gyro_radps.z() += 0.5 * std::sin(t);
    if (moves) s.accel_mps2 += shake_mps2 * m;
    samples.push_back(s);
  }
  return samples;
}

const Finding* find(const FindingList& findings, const std::string& id, const std::string& words) {
  for (const Finding& f : findings) {
    if (f.id == id && f.text.find(words) != std::string::npos) return &f;
  }
  return nullptr;
}

TEST(ImuStudy, a_good_recording_has_no_warning) {
  FindingList findings;
  const ImuStudy study = study_imu(drive_off(), 0.005, 1.0, "/imu", findings);
  for (const Finding& f : findings) EXPECT_EQ(f.severity, Severity::kInfo) << f.text;
  EXPECT_TRUE(study.rest_at_start);
  EXPECT_GT(study.up_imu.z(), 0.999);
  // 0.02 m/s^2 at 200 Hz
  EXPECT_NEAR(study.accel_noise_mps2_rthz, 0.02 * std::sqrt(0.005), 0.0003);
}

TEST(ImuStudy, accelerations_in_g_are_detected) {
  auto samples = drive_off();
  for (auto& s : samples) s.accel_mps2 /= 9.81;
  FindingList findings;
  const ImuStudy study = study_imu(samples, 0.005, 1.0, "/imu", findings);
  EXPECT_NEAR(study.accel_scale, 9.81, 0.2);
  EXPECT_NE(find(findings, "D08", ""), nullptr);
}

TEST(ImuStudy, removed_gravity_is_an_error) {
  auto samples = drive_off();
  for (auto& s : samples) s.accel_mps2.z() -= 9.81;
  FindingList findings;
  EXPECT_FALSE(study_imu(samples, 0.005, 1.0, "/imu", findings).units_known);
  const Finding* f = find(findings, "D08", "");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->severity, Severity::kError);
  EXPECT_FALSE(f->remedy.empty());
}

TEST(ImuStudy, an_imu_mounted_turned_as_stated_is_no_warning) {
  const geometry::Mat3 R_body_imu = geometry::rotation_from_rpy(3.0, -0.6, 1.7);
  auto samples = drive_off();
  for (auto& s : samples) s.accel_mps2 = R_body_imu.transpose() * s.accel_mps2;
  FindingList findings;
  (void)study_imu(samples, 0.005, 1.0, "/imu", findings, R_body_imu);
  ASSERT_NE(find(findings, "D13", "body's z axis"), nullptr);
  EXPECT_EQ(find(findings, "D13", "")->severity, Severity::kInfo);
  findings.clear();
  (void)study_imu(samples, 0.005, 1.0, "/imu", findings);
  EXPECT_EQ(find(findings, "D13", "IMU's z axis")->severity, Severity::kWarning);
}

TEST(ImuStudy, a_fast_curve_is_no_error_of_scale) {
  auto samples = drive_off();
  const Time curve = samples.front().t + Duration::from_s(3.0);
  for (auto& s : samples) s.accel_mps2.y() += s.t > curve ? 3.5 : 0.0;
  FindingList findings;
  (void)study_imu(samples, 0.005, 1.0, "/imu", findings);
  EXPECT_EQ(find(findings, "D08", "scale"), nullptr);
  for (auto& s : samples) s.accel_mps2.z() *= s.t > curve ? 1.06 : 1.0;
  (void)study_imu(samples, 0.005, 1.0, "/imu", findings);
  EXPECT_NE(find(findings, "D08", "scale"), nullptr);
}

TEST(ImuStudy, vibration_is_measured_relative_to_standstill) {
  FindingList findings;
  const ImuStudy study = study_imu(drive_off(2.0), 0.005, 1.0, "/imu", findings);
  EXPECT_GT(study.vibration_factor, 50.0);
  const Finding* f = find(findings, "D10", "shakes");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->severity, Severity::kWarning);
}

TEST(ImuStudy, a_start_in_motion_is_reported) {
  auto samples = drive_off();
  samples.erase(samples.begin(), samples.begin() + 600);
  FindingList findings;
  EXPECT_FALSE(study_imu(samples, 0.005, 1.0, "/imu", findings).rest_at_start);
  EXPECT_NE(find(findings, "D13", "motion"), nullptr);
}

TEST(ImuStudy, saturated_gyro_samples_are_counted) {
  auto samples = drive_off();
  for (std::size_t i = 1000; i < 1100; ++i) samples[i].gyro_radps.z() = 4.36;
  FindingList findings;
  EXPECT_EQ(study_imu(samples, 0.005, 1.0, "/imu", findings).saturated, 100U);
  EXPECT_NE(find(findings, "D10", "range"), nullptr);
}

TEST(ImuStudy, nan_samples_are_counted_and_skipped) {
  auto samples = drive_off();
  for (std::size_t i = 0; i < samples.size(); i += 100) {
    samples[i].accel_mps2.x() = std::numeric_limits<double>::quiet_NaN();
  }
  FindingList findings;
  const ImuStudy study = study_imu(samples, 0.005, 1.0, "/imu", findings);
  EXPECT_EQ(study.invalid, 20U);
  EXPECT_TRUE(study.up_imu.allFinite());
}

TEST(ImuStudy, empty_and_all_zero_input_does_not_crash) {
  FindingList findings;
  EXPECT_EQ(study_imu({}, 0.0, {}, "/imu", findings).saturated, 0U);
  const std::vector<sensor::ImuSample> zeros(100);
  static_cast<void>(study_imu(zeros, 0.005, 1.0, "/imu", findings));
}

}  // namespace
}  // namespace rali::inspect
