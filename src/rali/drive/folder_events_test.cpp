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

void write_sweeps(const io::TestFolder& folder) {
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

TEST(FolderEvents, refuse_inertial_data_that_gives_no_sample) {
  const io::TestFolder folder;
  write_sweeps(folder);
  folder.write("imu.csv", imu_rows(99.8, 0.01, "nan,nan,nan,nan,nan,nan"));
  EXPECT_TRUE(holds(refusal(folder), "0 of its 100 rows can be used")) << refusal(folder);
  folder.write("imu.csv", imu_rows(99.8, 0.01, "0,0,0,1e200,1e200,1e200"));
  EXPECT_TRUE(holds(refusal(folder), "0 of its 100 rows can be used")) << refusal(folder);
  folder.write("imu.csv", imu_rows(100.8, -0.01, "0,0,0,0,0,9.81"));
  EXPECT_TRUE(holds(refusal(folder), "1 of its 100 rows can be used")) << refusal(folder);
}

TEST(FolderEvents, refuse_inertial_data_of_another_time) {
  const io::TestFolder folder;
  write_sweeps(folder);
  folder.write("imu.csv", imu_rows(50.0, 0.01, "0,0,0,0,0,9.81"));
  EXPECT_TRUE(holds(refusal(folder), "before the first sweep")) << refusal(folder);
  folder.write("imu.csv", imu_rows(500.0, 0.01, "0,0,0,0,0,9.81"));
  EXPECT_TRUE(holds(refusal(folder), "after the last sweep")) << refusal(folder);
  folder.write("imu.csv", imu_rows(99.8, 0.01, "0,0,0,0,0,9.81"));
  EXPECT_EQ(refusal(folder), "accepted");
}

TEST(FolderEvents, say_why_no_cloud_can_be_read) {
  const io::TestFolder folder;
  folder.write("0.bin", "");
  folder.write("1.bin", "");
  EXPECT_TRUE(holds(refusal(folder), "none of its 2 clouds can be read")) << refusal(folder);
  EXPECT_TRUE(holds(refusal(folder), "0.bin")) << refusal(folder);
}

TEST(FolderEvents, count_a_cut_sweep_as_damage) {
  const io::TestFolder folder;
  write_sweeps(folder);
  folder.write("2.bin", ring_of_points().substr(0, 16 * 400 + 5));
  const auto source = open_folder_events(folder.path(), "", InputOptions{});
  ASSERT_TRUE(source) << source.error().message();
  for (;;) {
    const auto event = (*source)->next();
    ASSERT_TRUE(event);
    if (!event->has_value()) break;
  }
  EXPECT_TRUE((*source)->report().gaps.damaged) << "a run with half a sweep ended with 0";
}

}  // namespace
}  // namespace rali::drive
