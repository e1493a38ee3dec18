#include "rali/inspect/rotation_findings.hpp"

#include <numbers>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/imu/turning_for_test.hpp"

namespace rali::inspect {
namespace {

using imu::test::TurningPair;

constexpr double kDeg = std::numbers::pi / 180.0;

const Finding* find(const FindingList& findings, const std::string& id) {
  for (const Finding& f : findings) {
    if (f.id == id) return &f;
  }
  return nullptr;
}

FindingList all_findings(const TurningPair& pair, const ExtrinsicsGiven& given,
                         const std::optional<geometry::Vec3>& up_lidar) {
  const auto lidar = pair.lidar();
  const auto imu = pair.imu();
  const imu::RotationStudy study = imu::study_rotations(lidar, imu);
  FindingList findings;
  report_gyro_unit(study, 0.0, "/imu", findings);
  report_time_offset(study, "/points", findings);
  report_extrinsics(study, given, lidar, imu, findings);
  report_up(up_lidar, geometry::Vec3::UnitZ(), study, given, "/points", findings);
  return findings;
}

TEST(RotationFindings, a_consistent_lidar_and_imu_give_no_warning) {
  for (const Finding& f : all_findings({}, {}, geometry::Vec3::UnitZ())) {
    EXPECT_EQ(f.severity, Severity::kInfo) << f.text;
  }
}

TEST(RotationFindings, a_38_ms_time_offset_is_an_error_with_the_setting) {
  TurningPair pair;
  pair.lidar_late_s = -0.038;
  const FindingList findings = all_findings(pair, {}, geometry::Vec3::UnitZ());
  const Finding* f = find(findings, "D12");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->severity, Severity::kError);
  EXPECT_NEAR(f->value, 0.038, 0.002);
  EXPECT_NE(f->remedy.find("lidar.time_offset_s: 0.03"), std::string::npos) << f->remedy;
}

TEST(RotationFindings, without_rotation_calibration_is_reported_as_not_observable) {
  TurningPair pair;
  pair.rate_radps = 0.0;
  const FindingList findings = all_findings(pair, {}, geometry::Vec3::UnitZ());
  for (const char* id : {"D09", "D11", "D12"}) {
    const Finding* f = find(findings, id);
    ASSERT_NE(f, nullptr);
    EXPECT_EQ(f->severity, Severity::kInfo);
    EXPECT_NE(f->text.find("not observable"), std::string::npos) << f->text;
  }
}

TEST(RotationFindings, gyro_rates_in_deg_per_s_are_detected) {
  TurningPair pair;
  pair.gyro_scale = 1.0 / kDeg;
  const FindingList findings = all_findings(pair, {}, geometry::Vec3::UnitZ());
  const Finding* f = find(findings, "D09");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->severity, Severity::kError);
  EXPECT_NE(f->text.find("deg/s"), std::string::npos);
}

TEST(RotationFindings, a_gyro_scale_is_not_judged_by_noise_or_in_degenerate_bends) {
  const auto severity = [](double ratio, double ratio_max, double degenerate_fraction) {
    imu::RotationStudy study;
    study.gyro_ratio = ratio;
    study.gyro_ratio_max = ratio_max;
    FindingList findings;
    report_gyro_unit(study, degenerate_fraction, "/imu", findings);
    return find(findings, "D09")->severity;
  };
  EXPECT_EQ(severity(0.80, 0.82, 0.0), Severity::kError);
  EXPECT_EQ(severity(0.80, 1.30, 0.0), Severity::kInfo) << "noise of the LiDAR lowers the ratio";
  EXPECT_EQ(severity(1.32, 1.40, 0.0), Severity::kError);
  EXPECT_EQ(severity(1.32, 1.40, 0.9), Severity::kInfo) << "its way, and so its turn, is unknown";
  EXPECT_EQ(severity(57.3, 57.9, 0.9), Severity::kError) << "deg/s";
}

// On a straight track the rotation that fits best is that of noise.
TEST(RotationFindings, mirrored_axes_are_not_concluded_from_rotations_that_do_not_fit) {
  imu::RotationStudy study;
  study.gyro_ratio = study.gyro_ratio_max = 1.0;
  study.second_axis_fraction = 0.9;
  study.best.R_imu_lidar = geometry::rotation_from_rpy(std::numbers::pi, 0.0, 0.0);
  for (const double misfit : {0.1, 0.6}) {
    study.best.misfit = misfit;
    FindingList findings;
    report_up(geometry::Vec3::UnitZ(), geometry::Vec3::UnitZ(), study, {}, "/points", findings);
    EXPECT_EQ(find(findings, "D07")->severity, misfit < 0.2 ? Severity::kError : Severity::kInfo);
  }
}

// In a straight pipe the LiDAR's turning is noise, and the gyro's next to nothing.
TEST(RotationFindings, clocks_are_not_suspected_where_the_gyro_did_not_turn) {
  imu::RotationStudy study;
  study.turn_rate_rms = 0.2;
  study.offset_at_border = true;
  for (const double gyro_rate_rms : {0.01, 0.2}) {
    study.gyro_rate_rms = gyro_rate_rms;
    FindingList findings;
    report_time_offset(study, "/points", findings);
    EXPECT_EQ(find(findings, "D12")->severity,
              gyro_rate_rms < 0.1 ? Severity::kInfo : Severity::kWarning);
  }
}

TEST(RotationFindings, an_inverted_extrinsic_rotation_is_distinguished_from_the_correct_one) {
  TurningPair pair;
  pair.R_imu_lidar = geometry::rotation_from_rpy(0.0, 0.3, 0.9);
  ExtrinsicsGiven right, inverse;
  right.R_body_lidar = pair.R_imu_lidar;
  inverse.R_body_lidar = pair.R_imu_lidar.transpose();
  const FindingList good = all_findings(pair, right, {});
  EXPECT_EQ(find(good, "D11")->severity, Severity::kInfo) << find(good, "D11")->text;
  const FindingList bad = all_findings(pair, inverse, {});
  EXPECT_EQ(find(bad, "D11")->severity, Severity::kError);
  EXPECT_NE(find(bad, "D11")->text.find("inverse"), std::string::npos) << find(bad, "D11")->text;
}

// Rough walls: the LiDAR's turns are noisy, yet they show that the IMU is mounted turned.
TEST(RotationFindings, a_turned_mounting_is_found_through_noise_as_the_map_finds_it) {
  TurningPair pair;
  pair.tilt_radps = 0.0;
  pair.R_imu_lidar = geometry::rotation_from_rpy(0.1, 18.0 * kDeg, 0.0);
  auto lidar = pair.lidar();
  Rng rng(11, "rough walls");
  for (imu::LidarTurn& turn : lidar) {
    turn.turn_lidar_rad += 0.008 * geometry::Vec3(rng.normal(), rng.normal(), rng.normal());
  }
  const auto imu = pair.imu();
  FindingList findings;
  report_extrinsics(imu::study_rotations(lidar, imu), {}, lidar, imu, findings);
  const Finding* f = find(findings, "D11");
  EXPECT_EQ(f->severity, Severity::kWarning) << f->text;
  EXPECT_NE(f->remedy.find("rpy_deg: [5"), std::string::npos) << f->remedy;
}

TEST(RotationFindings, swapped_axes_are_reported) {
  TurningPair pair;
  pair.R_imu_lidar = geometry::rotation_from_rpy(0.0, 0.0, 90.0 * kDeg);
  ExtrinsicsGiven given;
  given.R_body_lidar = geometry::rotation_from_rpy(90.0 * kDeg, 0.0, 90.0 * kDeg);
  const FindingList findings = all_findings(pair, given, {});
  EXPECT_EQ(find(findings, "D11")->severity, Severity::kError);
  EXPECT_NE(find(findings, "D11")->text.find("swapped"), std::string::npos)
      << find(findings, "D11")->text;
}

TEST(RotationFindings, the_rotation_of_the_imu_in_the_body_is_considered) {
  TurningPair pair;
  ExtrinsicsGiven given;
  given.R_body_imu = geometry::rotation_from_rpy(0.0, 0.0, 1.0);
  given.R_body_lidar = given.R_body_imu * pair.R_imu_lidar;
  EXPECT_EQ(find(all_findings(pair, given, {}), "D11")->severity, Severity::kInfo);
}

TEST(RotationFindings, mirrored_axes_are_detected_from_the_ground_normal) {
  TurningPair pair;
  pair.mirrored_y = true;
  const FindingList findings = all_findings(pair, {}, geometry::Vec3::UnitZ());
  const Finding* f = find(findings, "D07");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->severity, Severity::kError);
  EXPECT_NE(f->text.find("mirrored"), std::string::npos);
}

TEST(RotationFindings, an_upside_down_lidar_is_not_reported_as_mirrored) {
  TurningPair pair;
  pair.R_imu_lidar = geometry::rotation_from_rpy(std::numbers::pi, 0.0, 0.0);
  const FindingList findings = all_findings(pair, {}, geometry::Vec3(-geometry::Vec3::UnitZ()));
  EXPECT_EQ(find(findings, "D07")->text.find("mirrored"), std::string::npos);
  EXPECT_EQ(find(findings, "D07")->severity, Severity::kWarning);
}

// A dome that looks ahead: the plane that it takes for the ground is a wall.
TEST(RotationFindings, a_wall_taken_for_the_ground_does_not_overrule_the_turning) {
  TurningPair pair;
  ExtrinsicsGiven given;
  given.R_body_lidar = pair.R_imu_lidar;
  const geometry::Vec3 wall = pair.R_imu_lidar.transpose() * geometry::Vec3::UnitX();
  EXPECT_EQ(find(all_findings(pair, given, wall), "D07")->severity, Severity::kInfo);
  given.R_body_lidar = pair.R_imu_lidar * geometry::rotation_from_rpy(90.0 * kDeg, 0.0, 0.0);
  EXPECT_EQ(find(all_findings(pair, given, wall), "D07")->severity, Severity::kWarning);
}

}  // namespace
}  // namespace rali::inspect
