#include "rali/inspect/doctor.hpp"

#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/drive/hall_recording_for_test.hpp"

namespace rali::inspect {
namespace {

using drive::test::HallRecording;

/// A bag that goes when the test does.
class BagFile {
 public:
  BagFile(const HallRecording& recording, const std::string& name)
      : path_(recording.write((std::filesystem::path(testing::TempDir()) / name).string())) {}

  ~BagFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }

  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

DoctorReport examined(const HallRecording& recording, const std::string& name,
                      const std::optional<geometry::SE3>& T_body_lidar = {}) {
  const BagFile bag(recording, name);
  DoctorOptions options;
  options.path = bag.path();
  options.T_body_lidar = T_body_lidar;
  SerialExecutor executor;
  Result<DoctorReport> report = examine(options, executor);
  EXPECT_TRUE(report.has_value()) << (report ? "" : report.error().message());
  return report ? std::move(*report) : DoctorReport{};
}

const Finding* find(const DoctorReport& report, const std::string& id, Severity severity) {
  for (const Finding& f : report.findings) {
    if (f.id == id && f.severity == severity) return &f;
  }
  return nullptr;
}

TEST(Doctor, a_good_recording_is_fit) {
  const DoctorReport report = examined({}, "doctor_good.bag");
  EXPECT_FALSE(report.has_error()) << doctor_text(report);
  EXPECT_EQ(report.lidar_topic, "/points");
  EXPECT_EQ(report.imu_topic, "/imu/data");
  ASSERT_TRUE(report.rotations.time_offset_s.has_value()) << doctor_text(report);
  EXPECT_NEAR(*report.rotations.time_offset_s, 0.0, 0.005);
  EXPECT_NEAR(report.rotations.gyro_ratio, 1.0, 0.03);
}

TEST(Doctor, finds_38_ms_between_lidar_and_imu) {
  HallRecording recording;
  recording.lidar_shift_s = -0.038;
  const DoctorReport report = examined(recording, "doctor_offset.bag");
  const Finding* f = find(report, "D12", Severity::kError);
  ASSERT_NE(f, nullptr) << doctor_text(report);
  EXPECT_NEAR(f->value, 0.038, 0.005);
}

TEST(Doctor, finds_degrees_g_a_gap_nan_and_a_second_lidar_at_once) {
  HallRecording recording;
  recording.gyro_factor = 57.29578;
  recording.accel_factor = 1.0 / 9.80665;
  recording.gap_from = 60;
  recording.gap_sweeps = 4;
  recording.nan_share = 0.6;
  recording.second_cloud_topic = "/points_rear";
  const DoctorReport report = examined(recording, "doctor_faults.bag");
  const std::string text = doctor_text(report);
  EXPECT_NE(find(report, "D09", Severity::kError), nullptr) << text;
  EXPECT_NE(find(report, "D08", Severity::kWarning), nullptr) << text;
  EXPECT_NE(find(report, "D05", Severity::kWarning), nullptr) << text;
  EXPECT_NE(text.find("longest gap 0.50 s"), std::string::npos) << text;
  EXPECT_NE(text.find("2 point cloud topics"), std::string::npos) << text;
  EXPECT_NEAR(report.gyro_scale, 0.01745, 1e-4);
}

TEST(Doctor, tells_an_inverted_extrinsic_from_the_right_one) {
  HallRecording recording;
  recording.R_body_lidar = geometry::rotation_from_rpy(0.0, 0.0, 1.2);
  const geometry::SE3 right{recording.R_body_lidar, geometry::Vec3::Zero()};
  EXPECT_EQ(find(examined(recording, "doctor_right.bag", right), "D11", Severity::kError), nullptr);
  const DoctorReport wrong = examined(recording, "doctor_inverse.bag", right.inverse());
  const Finding* f = find(wrong, "D11", Severity::kError);
  ASSERT_NE(f, nullptr) << doctor_text(wrong);
  EXPECT_NE(f->text.find("inverse"), std::string::npos) << f->text;
}

TEST(Doctor, json_is_one_document_and_yaml_names_what_was_found) {
  HallRecording recording;
  recording.duration_s = 3.0;
  const DoctorReport report = examined(recording, "doctor_short.bag");
  const auto json = nlohmann::json::parse(doctor_json(report));
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["found"]["lidar_topic"], "/points");
  ASSERT_FALSE(json["findings"].empty());
  EXPECT_TRUE(json["findings"][0].contains("remedy"));
  const std::string yaml = doctor_fleet_yaml({report});
  EXPECT_NE(yaml.find("topic: \"/points\""), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("accel_unit: m_s2"), std::string::npos) << yaml;
}

TEST(Doctor, findings_come_worst_first) {
  HallRecording recording;
  recording.duration_s = 1.0;
  recording.nan_share = 0.9;
  const DoctorReport report = examined(recording, "doctor_sorted.bag");
  for (std::size_t i = 1; i < report.findings.size(); ++i) {
    EXPECT_GE(report.findings[i - 1].severity, report.findings[i].severity);
  }
}

TEST(Doctor, a_bag_cut_at_any_place_is_examined_or_refused) {
  HallRecording recording;
  recording.duration_s = 0.5;
  const BagFile bag(recording, "doctor_cut.bag");
  const auto size = std::filesystem::file_size(bag.path());
  SerialExecutor executor;
  DoctorOptions options;
  options.path = bag.path();
  for (int part = 9; part >= 0; --part) {
    std::filesystem::resize_file(bag.path(), size * static_cast<std::uintmax_t>(part) / 10);
    const auto report = examine(options, executor);
    const bool told = report ? !report->findings.empty() : !report.error().what.empty();
    EXPECT_TRUE(told) << part;
  }
}

TEST(Doctor, what_is_no_recording_is_refused_with_a_sentence) {
  SerialExecutor executor;
  DoctorOptions options;
  options.path = "/nonexistent/run.bag";
  const auto report = examine(options, executor);
  ASSERT_FALSE(report.has_value());
  EXPECT_EQ(report.error().code, ErrorCode::kInput);
}

}  // namespace
}  // namespace rali::inspect
