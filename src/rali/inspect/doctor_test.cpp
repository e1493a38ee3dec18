#include "rali/inspect/doctor.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/drive/hall_recording_for_test.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/wire/byte_writer.hpp"

namespace rali::inspect {
namespace {

using drive::test::HallRecording;

/// A bag file that is deleted at the end of the test.
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
  RangeStudy ranges;
  Result<DoctorReport> report = examine(options, executor, ranges);
  EXPECT_TRUE(report.has_value()) << (report ? "" : report.error().message());
  return report ? std::move(*report) : DoctorReport{};
}

const Finding* find(const DoctorReport& report, const std::string& id, Severity severity) {
  for (const Finding& f : report.findings) {
    if (f.id == id && f.severity == severity) return &f;
  }
  return nullptr;
}

TEST(Doctor, a_good_recording_has_no_errors) {
  const DoctorReport report = examined({}, "doctor_good.bag");
  EXPECT_FALSE(has_error(report.findings)) << doctor_text(report);
  EXPECT_EQ(report.lidar_topic, "/points");
  EXPECT_EQ(report.imu_topic, "/imu/data");
  ASSERT_TRUE(report.rotations.time_offset_s.has_value()) << doctor_text(report);
  EXPECT_NEAR(*report.rotations.time_offset_s, 0.0, 0.005);
  EXPECT_NEAR(report.rotations.gyro_ratio, 1.0, 0.03);
}

TEST(Doctor, finds_a_38_ms_time_offset_between_lidar_and_imu) {
  HallRecording recording;
  recording.lidar_shift_s = -0.038;
  const DoctorReport report = examined(recording, "doctor_offset.bag");
  const Finding* f = find(report, "D12", Severity::kError);
  ASSERT_NE(f, nullptr) << doctor_text(report);
  EXPECT_NEAR(f->value, 0.038, 0.005);
}

TEST(Doctor, finds_wrong_units_gap_nan_and_second_lidar_at_once) {
  HallRecording recording;
  recording.gyro_factor = 57.29578;
  recording.accel_factor = 1.0 / 9.80665;
  recording.gap_from = 60;
  recording.gap_scans = 4;
  recording.nan_fraction = 0.6;
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

TEST(Doctor, distinguishes_an_inverted_extrinsic_from_the_correct_one) {
  HallRecording recording;
  recording.R_body_lidar = geometry::rotation_from_rpy(0.0, 0.0, 1.2);
  const geometry::SE3 right{recording.R_body_lidar, geometry::Vec3::Zero()};
  EXPECT_EQ(find(examined(recording, "doctor_right.bag", right), "D11", Severity::kError), nullptr);
  const DoctorReport wrong = examined(recording, "doctor_inverse.bag", right.inverse());
  const Finding* f = find(wrong, "D11", Severity::kError);
  ASSERT_NE(f, nullptr) << doctor_text(wrong);
  EXPECT_NE(f->text.find("inverse"), std::string::npos) << f->text;
}

TEST(Doctor, json_is_one_document_and_yaml_contains_the_detected_settings) {
  HallRecording recording;
  recording.duration_s = 3.0;
  const DoctorReport report = examined(recording, "doctor_short.bag");
  for (const std::size_t n : {1U, 3U}) {
    DoctorResult result;
    result.recordings.assign(n, report);
    result.recordings.back().vehicle = "v9";
    const auto json = nlohmann::json::parse(doctor_json(result));
    EXPECT_EQ(json["schema"], 2);
    ASSERT_EQ(json["vehicles"].size(), n) << "one shape for any number";
    EXPECT_EQ(json["vehicles"][n - 1]["vehicle"], "v9");
    EXPECT_EQ(json["vehicles"][0]["found"]["lidar_topic"], "/points");
    ASSERT_EQ(json["findings"].size(), n * report.findings.size());
    EXPECT_TRUE(json["findings"][0].contains("remedy"));
    EXPECT_EQ(json["findings"][0]["path"], report.path);
  }
  const std::string list = doctor_fleet_yaml({report, report});
  EXPECT_NE(list.find("recording: [\""), std::string::npos) << list;
  const std::string yaml = doctor_fleet_yaml({report});
  EXPECT_NE(yaml.find("topic: \"/points\""), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("accel_unit: m_s2"), std::string::npos) << yaml;
}

TEST(Doctor, findings_are_sorted_by_severity) {
  HallRecording recording;
  recording.duration_s = 1.0;
  recording.nan_fraction = 0.9;
  const DoctorReport report = examined(recording, "doctor_sorted.bag");
  for (std::size_t i = 1; i < report.findings.size(); ++i) {
    EXPECT_GE(report.findings[i - 1].severity, report.findings[i].severity);
  }
}

TEST(Doctor, a_bag_truncated_at_any_offset_is_examined_or_refused) {
  HallRecording recording;
  recording.duration_s = 0.5;
  const BagFile bag(recording, "doctor_cut.bag");
  const auto size = std::filesystem::file_size(bag.path());
  SerialExecutor executor;
  RangeStudy ranges;
  DoctorOptions options;
  options.path = bag.path();
  for (int part = 9; part >= 0; --part) {
    std::filesystem::resize_file(bag.path(), size * static_cast<std::uintmax_t>(part) / 10);
    const auto report = examine(options, executor, ranges);
    const bool reported = report ? !report->findings.empty() : !report.error().what.empty();
    EXPECT_TRUE(reported) << part;
  }
}

TEST(Doctor, a_missing_recording_is_an_input_error) {
  SerialExecutor executor;
  RangeStudy ranges;
  DoctorOptions options;
  options.path = "/nonexistent/run.bag";
  const auto report = examine(options, executor, ranges);
  ASSERT_FALSE(report.has_value());
  EXPECT_EQ(report.error().code, ErrorCode::kInput);
}

/// A folder of three scans, one ring each; `factor` is the unit of its file, 0 makes NaN of it.
DoctorReport examined_folder(double factor) {
  const io::TestFolder folder;
  for (int i = 0; i < 3; ++i) {
    std::string pcd =
        "VERSION .7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
        "WIDTH 720\nHEIGHT 1\nPOINTS 720\nDATA ascii\n";
    for (int k = 0; k < 720; ++k) {
      const double a = 0.00872665 * k;
      pcd += factor == 0.0 ? "nan nan nan 0\n"
                           : fmt::format("{} {} {} 1\n", factor * 8.0 * std::cos(a),
                                         factor * 8.0 * std::sin(a), 0.2 * factor);
    }
    folder.write(fmt::format("{}.pcd", i), pcd);
  }
  DoctorOptions options;
  options.path = folder.path();
  SerialExecutor executor;
  RangeStudy ranges;
  Result<DoctorReport> report = examine(options, executor, ranges);
  EXPECT_TRUE(report) << (report ? "" : report.error().message());
  return report ? std::move(*report) : DoctorReport{};
}

TEST(Doctor, a_folder_without_usable_points_is_an_error) {
  EXPECT_FALSE(has_error(examined_folder(1.0).findings)) << doctor_text(examined_folder(1.0));
  const DoctorReport nan = examined_folder(0.0);
  ASSERT_NE(find(nan, "D01", Severity::kError), nullptr) << doctor_text(nan);
  EXPECT_NE(doctor_text(nan).find("3 scans without a usable point"), std::string::npos);
  const auto of = [&](const char* id) {
    return std::count_if(nan.findings.begin(), nan.findings.end(),
                         [&](const Finding& f) { return f.id == id; });
  };
  EXPECT_EQ(of("D05"), 1) << doctor_text(nan);
  EXPECT_EQ(of("D06"), 1) << doctor_text(nan);
  EXPECT_NE(doctor_text(nan).find(" 100 % of the points are NaN"), std::string::npos);
  const DoctorReport mm = examined_folder(1000.0);
  ASSERT_NE(find(mm, "D01", Severity::kError), nullptr) << doctor_text(mm);
  EXPECT_NE(doctor_text(mm).find("millimetres, not metres"), std::string::npos) << doctor_text(mm);
}

TEST(Doctor, ranges_of_all_files_are_evaluated_together) {
  const io::TestFolder folder;
  std::string forth = "stamp_s,from,to,range_m\n", back = forth;
  for (int i = 0; i < 40; ++i) {
    forth += fmt::format("{},v1,v2,{}\n", 0.1 * i, 5.0 + 0.01 * i);
    back += fmt::format("{},v2,v1,{}\n", 0.1 * i + 0.05, 5.31 + 0.01 * i);
  }
  back += "9.0,v7,v1,3.0\nnoon,v1,v2,3.0\n";
  RangeStudy ranges;
  const auto findings = examine_ranges(
      {{folder.write("a.csv", forth), folder.write("b.csv", back)}, {}, {"v1", "v2"}, {}, false},
      {}, ranges);
  ASSERT_TRUE(findings) << findings.error().message();
  const std::string text = ranges_text(*findings);
  EXPECT_NE(text.find("warning D15 v1->v2 is -0.3"), std::string::npos) << text;
  EXPECT_NE(text.find("'v7' is no vehicle (v1, v2); 1 range with it"), std::string::npos) << text;
  EXPECT_NE(text.find("1 of 42 rows like this"), std::string::npos) << text;
}

/// A bag of ten LinkTrack frames on /uwb: radio 4 measures radios 5 and 7.
std::string linktrack_bag(const io::TestFolder& folder) {
  constexpr const char* kType = "nlink_parser/LinktrackNodeframe3";
  io::MemorySink sink;
  io::BagWriter bag(sink, io::BagWriter::Options{});
  const auto topic = bag.add_connection("/uwb", kType, "0", "");
  bool whole = topic.has_value();
  for (std::uint32_t i = 0; whole && i < 10; ++i) {
    wire::ByteWriter out(wire::Encoding::kRos1);
    out.put(std::uint8_t{2});
    out.put(std::uint8_t{4});
    out.put(100 * i);
    out.put(100 * i);
    out.put(4.9F);
    out.put(std::uint32_t{2});
    for (const std::uint8_t peer : {std::uint8_t{5}, std::uint8_t{7}}) {
      out.put(std::uint8_t{2});
      out.put(peer);
      for (const float value : {3.0F, -80.0F, -78.0F}) out.put(value);
    }
    whole = bag.write(*topic, Time::from_s(10.0 + 0.1 * i), out.take()).has_value();
  }
  EXPECT_TRUE(whole && bag.close());
  const auto& bytes = sink.bytes();
  return folder.write("uwb.bag", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

TEST(Doctor, an_unlisted_radio_belongs_to_the_vehicle_of_the_recording) {
  const io::TestFolder folder;
  DoctorOptions options;
  options.path = linktrack_bag(folder);
  options.vehicle = "v1";
  options.range_topics = {{"/uwb", {{5, "v1"}, {7, "v2"}}}};
  SerialExecutor executor;
  RangeStudy ranges;
  ASSERT_TRUE(examine(options, executor, ranges));
  EXPECT_EQ(ranges.names(), (std::vector<std::string>{"v1", "v2"}))
      << "4 is a second radio of v1, and what it measures to radio 5 is no range between vehicles";
}

}  // namespace
}  // namespace rali::inspect
