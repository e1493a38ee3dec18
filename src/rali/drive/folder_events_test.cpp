#include "rali/drive/folder_events.hpp"

#include <cmath>
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "rali/io/files/test_folder.hpp"

namespace rali::drive {
namespace {

/// A ring of points as KITTI x y z intensity.
std::string ring_of_points() {
  std::string bytes;
  for (int i = 0; i < 720; ++i) {
    const float angle = static_cast<float>(i) * 0.00872665F;
    const float point[4] = {8.0F * std::cos(angle), -8.0F * std::sin(angle), 0.2F, 0.5F};
    char raw[sizeof point];
    std::memcpy(raw, point, sizeof point);
    bytes.append(raw, sizeof raw);
  }
  return bytes;
}

void write_scans(const io::TestFolder& folder) {
  std::string times;
  for (int i = 0; i < 4; ++i) {
    folder.write(std::to_string(i) + ".bin", ring_of_points());
    times += std::to_string(100.0 + 0.1 * i) + '\n';
  }
  folder.write("times.txt", times);
}

std::string imu_rows(double t_s, double step_s, const std::string& values) {
  std::string text = "stamp_s,gx,gy,gz,ax,ay,az\n";
  for (int i = 0; i < 100; ++i) text += std::to_string(t_s + step_s * i) + ',' + values + '\n';
  return text;
}

std::string refusal(const io::TestFolder& folder) {
  const auto source = open_folder_events(folder.path(), "", InputOptions{});
  return source ? std::string("accepted") : source.error().message();
}

bool holds(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

TEST(FolderEvents, refuse_inertial_data_with_at_most_one_usable_row) {
  const io::TestFolder folder;
  write_scans(folder);
  folder.write("imu.csv", imu_rows(99.8, 0.01, "nan,nan,nan,nan,nan,nan"));
  EXPECT_TRUE(holds(refusal(folder), "0 of its 100 rows can be used")) << refusal(folder);
  folder.write("imu.csv", imu_rows(99.8, 0.01, "0,0,0,1e200,1e200,1e200"));
  EXPECT_TRUE(holds(refusal(folder), "0 of its 100 rows can be used")) << refusal(folder);
  folder.write("imu.csv", imu_rows(100.8, -0.01, "0,0,0,0,0,9.81"));
  EXPECT_TRUE(holds(refusal(folder), "1 of its 100 rows can be used")) << refusal(folder);
}

TEST(FolderEvents, refuse_inertial_data_outside_the_time_of_the_scans) {
  const io::TestFolder folder;
  write_scans(folder);
  folder.write("imu.csv", imu_rows(50.0, 0.01, "0,0,0,0,0,9.81"));
  EXPECT_TRUE(holds(refusal(folder), "before the first scan")) << refusal(folder);
  folder.write("imu.csv", imu_rows(500.0, 0.01, "0,0,0,0,0,9.81"));
  EXPECT_TRUE(holds(refusal(folder), "after the last scan")) << refusal(folder);
  folder.write("imu.csv", imu_rows(99.8, 0.01, "0,0,0,0,0,9.81"));
  EXPECT_EQ(refusal(folder), "accepted");
}

TEST(FolderEvents, report_why_no_cloud_can_be_read) {
  const io::TestFolder folder;
  folder.write("0.bin", "");
  folder.write("1.bin", "");
  EXPECT_TRUE(holds(refusal(folder), "none of its 2 clouds can be read")) << refusal(folder);
  EXPECT_TRUE(holds(refusal(folder), "0.bin")) << refusal(folder);
}

void drain(ReportedSource& source) {
  while (true) {
    const auto event = source.next();
    ASSERT_TRUE(event);
    if (!event->has_value()) return;
  }
}

TEST(FolderEvents, sort_inertial_rows_and_count_those_too_late_to_sort) {
  const io::TestFolder folder;
  write_scans(folder);
  std::string rows = imu_rows(99.8, 0.01, "0,0,0,0,0,9.81");
  rows.insert(rows.find("100.5"), "99.855,0,0,0,0,0,9.81\n");   // 0.6 s late
  rows.insert(rows.find("100.2"), "100.155,0,0,0,0,0,9.81\n");  // within the window
  folder.write("imu.csv", rows);
  const auto source = open_folder_events(folder.path(), "", InputOptions{});
  ASSERT_TRUE(source) << source.error().message();
  drain(**source);
  const InputReport& report = (*source)->report();
  EXPECT_EQ(report.gaps.late, 1U);
  EXPECT_EQ(report.imu_samples, 82U) << "until 0.3 s after the last scan";
  EXPECT_EQ(report.gaps.repeated, 0U);
}

TEST(FolderEvents, add_the_clock_offset_to_scans_and_inertial_samples) {
  const io::TestFolder folder;
  write_scans(folder);
  folder.write("imu.csv", imu_rows(99.8, 0.01, "0,0,0,0,0,9.81"));
  InputOptions options;
  options.clock_offset.value_s = 7.0;
  const auto plain = open_folder_events(folder.path(), "", InputOptions{});
  const auto moved = open_folder_events(folder.path(), "", options);
  ASSERT_TRUE(plain && moved);
  drain(**plain);
  drain(**moved);
  const InputReport &p = (*plain)->report(), &m = (*moved)->report();
  EXPECT_EQ(m.t_start, p.t_start + Duration::from_s(7.0)) << "an inertial sample";
  EXPECT_EQ(m.t_end, p.t_end + Duration::from_s(7.0));
  EXPECT_EQ(m.scans, p.scans);
  EXPECT_EQ(m.imu_samples, p.imu_samples);
}

TEST(FolderEvents, an_empty_cloud_is_a_missing_scan) {
  const io::TestFolder folder;
  for (int i = 0; i < 4; ++i) {
    std::string pcd =
        "VERSION .7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
        "WIDTH 720\nHEIGHT 1\nPOINTS 720\nDATA ascii\n";
    for (int k = 0; k < 720; ++k) {
      const double angle = 0.00872665 * k;
      pcd += i == 2 ? "nan nan nan 0\n"
                    : std::to_string(8.0 * std::cos(angle)) + ' ' +
                          std::to_string(8.0 * std::sin(angle)) + " 0.2 1\n";
    }
    folder.write(std::to_string(i) + ".pcd", pcd);
  }
  const auto source = open_folder_events(folder.path(), "", InputOptions{});
  ASSERT_TRUE(source) << source.error().message();
  drain(**source);
  EXPECT_EQ((*source)->report().gaps.empty_scans, 1U);
  EXPECT_NEAR((*source)->report().gaps.missing_s, 0.1, 1e-6);
  EXPECT_TRUE((*source)->report().gaps.damaged) << "exit code 3, as for a file that is cut";
}

TEST(FolderEvents, count_a_truncated_scan_as_damage) {
  const io::TestFolder folder;
  write_scans(folder);
  folder.write("2.bin", ring_of_points().substr(0, 16 * 400 + 5));
  const auto source = open_folder_events(folder.path(), "", InputOptions{});
  ASSERT_TRUE(source) << source.error().message();
  drain(**source);
  EXPECT_TRUE((*source)->report().gaps.damaged) << "a run with half a scan ended with 0";
}

}  // namespace
}  // namespace rali::drive
