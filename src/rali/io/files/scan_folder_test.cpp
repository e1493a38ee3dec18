#include "rali/io/files/scan_folder.hpp"

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

/// KITTI points far enough out to pass as a scan; the intensity identifies the scan.
std::string scan(float intensity, int points = 4) {
  std::string out;
  for (int i = 0; i < points; ++i) {
    const float values[] = {5.0F, 6.0F, 1.0F, intensity};
    char raw[sizeof values];
    std::memcpy(raw, values, sizeof values);
    out.append(raw, sizeof raw);
  }
  return out;
}

double first_intensity(const CloudFile& cloud) { return cloud.column(cloud.field("intensity"))[0]; }

TEST(ScanFolder, reads_scans_in_natural_order_at_10_hz) {
  const TestFolder folder;
  folder.write("10.bin", scan(10));
  folder.write("9.bin", scan(9));
  folder.write("2.bin", scan(2));
  folder.write(".hidden.bin", "rubbish");
  folder.write("notes.txt", "text");
  folder.write("imu.csv", "stamp_s\n");
  auto scans = ScanFolder::open(folder.path());
  ASSERT_TRUE(scans) << scans.error().message();
  ASSERT_EQ(scans->entries().size(), 3U);
  EXPECT_TRUE(scans->times_assumed());
  EXPECT_EQ(scans->imu_path(), folder.path("imu.csv"));
  EXPECT_FALSE(scans->calib_path());
  ASSERT_EQ(scans->findings().size(), 1U);
  EXPECT_EQ(scans->findings()[0].text,
            folder.path() + ": no times.txt; 10 scans a second are assumed");
  CloudFile cloud;
  Time t;
  const double order[] = {2, 9, 10};
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(scans->next(cloud, t).value());
    EXPECT_EQ(first_intensity(cloud), order[i]);
    EXPECT_EQ(t.ns, 100000000 * i);
  }
  EXPECT_FALSE(scans->next(cloud, t).value());
  scans->rewind();
  EXPECT_TRUE(scans->next(cloud, t).value());
}

TEST(ScanFolder, takes_stamps_from_times_txt) {
  const TestFolder folder;
  folder.write("a.bin", scan(1));
  folder.write("b.bin", scan(2));
  folder.write("times.txt", "# seconds\n1630577758.000000001\r\n\n1630577758.1\n");
  auto scans = ScanFolder::open(folder.path());
  ASSERT_TRUE(scans) << scans.error().message();
  EXPECT_FALSE(scans->times_assumed());
  EXPECT_TRUE(scans->findings().empty());
  EXPECT_EQ(scans->entries()[0].t.ns, 1630577758000000001);
  EXPECT_EQ(scans->entries()[1].t.ns, 1630577758100000000);
}

TEST(ScanFolder, invalid_or_mismatched_times_are_refused) {
  const TestFolder folder;
  folder.write("a.bin", scan(1));
  folder.write("b.bin", scan(2));
  const std::string times = folder.path("times.txt");
  folder.write("times.txt", "1\n");
  EXPECT_EQ(ScanFolder::open(folder.path()).error().message(),
            times + ": has 1 stamps for 2 scans. There must be one line for each scan.");
  folder.write("times.txt", "1\n2\n3\n4\n5\n6\n7\n8\n");
  EXPECT_FALSE(ScanFolder::open(folder.path()));
  folder.write("times.txt", "1\n2\n3\n");
  const auto surplus = ScanFolder::open(folder.path());
  ASSERT_TRUE(surplus);
  ASSERT_EQ(surplus->findings().size(), 1U);
  EXPECT_EQ(surplus->findings()[0].text,
            times + ": has 3 stamps for 2 scans; the last 1 are not used");
  folder.write("times.txt", "2\n1\n");
  EXPECT_EQ(ScanFolder::open(folder.path()).error().message(),
            times + ":2: '1' is not after the stamp before, 2.000000000.");
  folder.write("times.txt", "1\n2011-09-26 13:02:25\n");
  EXPECT_EQ(ScanFolder::open(folder.path()).error().where, times + ":2");
  folder.write("times.txt", "");
  EXPECT_EQ(ScanFolder::open(folder.path()).error().what, "is an empty file, not a list of times");
}

TEST(ScanFolder, damaged_scans_are_skipped_with_a_finding_and_truncated_ones_used) {
  const TestFolder folder;
  folder.write("1.bin", scan(1));
  folder.write("2.bin", "");
  folder.write("3.bin", scan(3).substr(0, 40));
  folder.write("4.bin", "this is text that somebody put here\n");
  folder.write("5.bin", scan(5));
  auto scans = ScanFolder::open(folder.path());
  ASSERT_TRUE(scans);
  CloudFile cloud;
  Time t;
  ASSERT_TRUE(scans->next(cloud, t).value());
  ASSERT_TRUE(scans->next(cloud, t).value());
  EXPECT_EQ(first_intensity(cloud), 3.0);
  EXPECT_EQ(cloud.size(), 2U);
  EXPECT_EQ(t.ns, 200000000) << "the gap of the damaged scan stays";
  ASSERT_TRUE(scans->next(cloud, t).value());
  EXPECT_EQ(first_intensity(cloud), 5.0);
  EXPECT_FALSE(scans->next(cloud, t).value());
  EXPECT_EQ(scans->skipped(), 2U);
  ASSERT_EQ(scans->findings().size(), 4U);
  EXPECT_EQ(scans->findings()[1].text,
            folder.path("2.bin") +
                ": is an empty file, not a point cloud (PCD, PLY, LAS or KITTI "
                ".bin). The scan is left out");
}

TEST(ScanFolder, names_the_reason_if_a_folder_has_no_scans) {
  const TestFolder folder;
  EXPECT_EQ(ScanFolder::open(folder.path()).error().what, "holds no scans (*.pcd, *.ply, *.bin)");
  folder.write("a.pcd", "x");
  folder.write("b.ply", "x");
  EXPECT_EQ(ScanFolder::open(folder.path()).error().what,
            "holds 1 .pcd and 1 .ply files; which are the scans is not known");
  EXPECT_EQ(ScanFolder::open("/nowhere").error().what, "is no folder that can be read");
}

/// tools/convert_compact_scans.py makes folders of the compact scans that tests use.
TEST(ScanFolder, reads_the_output_of_convert_compact_scans_py) {
  const TestFolder folder;
  std::filesystem::create_directory(folder.path("in"));
  const std::int16_t xyz[] = {400, -800, 4};  // units of 2.5 mm: 1.0, -2.0, 0.01 m
  char record[8];
  std::memcpy(record, xyz, 6);
  record[6] = 50;  // intensity 0.5
  record[7] = 13;  // ring
  folder.write("in/0.xyzir", std::string(record, 8) + std::string(record, 8) + "cut");
  folder.write("poses.tum", "# stamp\n1630577758.569490 0 0 0 0 0 0 1\n");
  for (const std::string format : {"bin", "pcd"}) {
    const std::string command = std::string("python3 ") + RALI_SOURCE_DIR +
                                "/tools/convert_compact_scans.py " + folder.path("in") + " " +
                                folder.path(format) + " --format " + format + " --times " +
                                folder.path("poses.tum") + " > /dev/null 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
    auto scans = ScanFolder::open(folder.path(format));
    ASSERT_TRUE(scans) << scans.error().message();
    CloudFile cloud;
    Time t;
    ASSERT_TRUE(scans->next(cloud, t).value()) << format;
    EXPECT_EQ(t.ns, 1630577758569490000);
    ASSERT_EQ(cloud.size(), 2U);
    EXPECT_EQ(cloud.column(cloud.field("x"))[1], 1.0);
    EXPECT_EQ(cloud.column(cloud.field("y"))[1], -2.0);
    EXPECT_FLOAT_EQ(static_cast<float>(cloud.column(cloud.field("z"))[1]), 0.01F);
    EXPECT_EQ(cloud.column(cloud.field("intensity"))[1], 0.5);
    EXPECT_EQ(cloud.field("ring") >= 0, format == "pcd");
  }
}

TEST(ScanFolder, reads_the_real_kitti_scans) {
  RALI_NEEDS_DATA("kitti_0005/scans64_full");
  auto scans = ScanFolder::open(real_data("kitti_0005/scans64_full"));
  ASSERT_TRUE(scans) << scans.error().message();
  CloudFile cloud;
  Time t;
  int read = 0;
  while (scans->next(cloud, t).value()) {
    EXPECT_GT(cloud.size(), 120000U);
    ++read;
  }
  EXPECT_EQ(read, 3);
  EXPECT_EQ(scans->skipped(), 0U);
}

}  // namespace
}  // namespace rali::io
